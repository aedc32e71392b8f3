//! Progress bars and spinners.

use super::interrupt;
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use std::time::Duration;

/// The fewest columns of a terminal on which a bar stands beside the stage and the percentage.
const MIN_BAR_COLUMNS: u16 = 36;

/// A progress bar of a stage of so many steps, on a terminal only; it is removed at the end. It shows a percentage and not the steps,
/// which differ by stage: a reading is counted in every chunk that it reaches.
pub fn bar(steps: u64, stage: &'static str, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let (_, columns) = console::Term::stderr().size();
    let template = match columns < MIN_BAR_COLUMNS {
        true => "{msg} {percent} %",
        false => "{msg:9} {wide_bar} {percent:>3} %, {eta} left",
    };
    let bar = ProgressBar::new(steps).with_finish(ProgressFinish::AndClear);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.set_message(stage);
    interrupt::register_bar(&bar);
    bar
}

/// A spinner with the elapsed time, for a stage without a count, on a terminal only; it is removed at the end.
pub fn spinner(stage: &'static str, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner().with_finish(ProgressFinish::AndClear);
    if let Ok(style) = ProgressStyle::with_template("{msg:9} {spinner} {elapsed}") {
        bar.set_style(style);
    }
    bar.set_message(stage);
    interrupt::register_bar(&bar);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
