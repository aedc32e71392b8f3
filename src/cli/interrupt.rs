//! Ctrl-C, and SIGTERM: the command ends at once, cleans up what nobody can use, and says what stays. A second signal waits for
//! nothing.
//!
//! The signals come to a thread of their own, so that no other has to ask for them. What must not be cut in two, such as the
//! renaming that makes a finished map the user's, is done under [`unbroken`]: the first signal waits for it.

use super::note;
use crate::output::{begun, discard};
use indicatif::{ProgressBar, WeakProgressBar};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

/// What is added to a signal's number to make the exit code, as shells do.
const SIGNALLED: i32 = 128;

/// Held while something must not be cut in two.
static GATE: Mutex<()> = Mutex::new(());
/// Whether a signal has come.
static COME: AtomicBool = AtomicBool::new(false);
static NOW: Mutex<Now> = Mutex::new(Now { bar: None, temporary: Vec::new(), output: None, complete: None });

/// What is under way.
struct Now {
    /// The progress bar that was shown last. It ends with its owner: held here it would stay on the screen.
    bar: Option<WeakProgressBar>,
    /// Files and folders that go when the command ends.
    temporary: Vec<PathBuf>,
    output: Option<Output>,
    /// The map that was finished.
    complete: Option<PathBuf>,
}

/// A map's folder under way.
struct Output {
    partial: PathBuf,
    /// The folders above it that were made for it, the innermost first.
    made: Vec<PathBuf>,
    /// Whether the command can go on with it another time, and says so.
    resumable: bool,
    /// Whether chunks are being written: it is no more to be removed under their writer's hands.
    writing: bool,
}

/// What must not be cut in two is done while this lives.
pub type Unbroken = MutexGuard<'static, ()>;

/// Begins something that must not be cut in two.
pub fn unbroken() -> Unbroken {
    GATE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn now() -> MutexGuard<'static, Now> {
    NOW.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A bar that is on the screen from now on: it is taken away before anything is said.
pub fn shows(bar: &ProgressBar) {
    now().bar = Some(bar.downgrade());
}

/// Prints something while a bar may be on the screen: the bar is taken away and drawn again.
pub fn aside(print: impl FnOnce()) {
    // Who holds the lock has taken the bar away.
    let bar = NOW.try_lock().ok().and_then(|now| now.bar.as_ref()?.upgrade());
    match bar.filter(|b| !b.is_finished()) {
        Some(bar) => bar.suspend(print),
        None => print(),
    }
}

/// A file or a folder that goes when a signal ends the command.
pub fn removes(path: &Path) {
    now().temporary.push(path.into());
}

/// The folders above `path` that are not there yet, the innermost first.
pub fn missing_above(path: &Path) -> Vec<PathBuf> {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
    path.ancestors().skip(1).take_while(|a| !a.exists()).map(PathBuf::from).collect()
}

/// A map is under way in `partial`; `made`: the folders above it that were made for it. `resumable`: `--resume` can go on with it.
pub fn output(partial: &Path, made: Vec<PathBuf>, resumable: bool) {
    now().output = Some(Output { partial: partial.into(), made, resumable, writing: false });
}

/// From now on the map's chunks are written.
pub fn writing() {
    let _whole = unbroken();
    if let Some(output) = &mut now().output {
        output.writing = true;
    }
}

/// The map under way is finished, and lies in `place`. Does not return where a signal waits: the command ends there.
pub fn finished(place: &Path, unbroken: Unbroken) {
    let mut now = now();
    (now.output, now.complete) = (None, Some(place.into()));
    drop((now, unbroken));
    while COME.load(Ordering::SeqCst) {
        std::thread::park();
    }
}

/// Begins to listen to the signals. Where they can't be listened to they end the process, as they do by default.
pub fn listen() {
    // Without a thread for it the signals do what they do by default.
    let _ = std::thread::Builder::new().name("signals".into()).spawn(|| {
        signals(|signal| {
            if COME.swap(true, Ordering::SeqCst) {
                leave(signal);
            }
            std::thread::spawn(move || end(signal));
        });
    });
}

/// Waits until nothing is under way that must not be cut in two, cleans up, says what stays, and ends the process.
fn end(signal: i32) {
    if !clear(now().bar.take().and_then(|bar| bar.upgrade())) && std::io::stderr().is_terminal() {
        // The terminal shows ^C.
        let _ = writeln!(std::io::stderr());
    }
    let _whole = match GATE.try_lock() {
        Ok(whole) => whole,
        Err(TryLockError::Poisoned(e)) => e.into_inner(),
        Err(TryLockError::WouldBlock) => {
            note!("interrupted: the files under way are being finished; Ctrl-C again ends it at once");
            unbroken()
        }
    };
    let mut now = now();
    clear(now.bar.take().and_then(|bar| bar.upgrade()));
    if let Some(output) = now.output.take() {
        let stays = output.writing || begun(&output.partial);
        if !stays {
            discard(&output.partial);
            // What holds anything else stays: only empty folders can be removed so.
            output.made.iter().take_while(|folder| std::fs::remove_dir(folder).is_ok()).count();
        }
        match (stays, output.resumable) {
            (true, true) => note!(
                "interrupted: the unfinished map stays in {}; give the same command with --resume to go on with it, or with \
                 --overwrite to begin anew",
                output.partial.display()
            ),
            (false, true) => note!("interrupted: nothing was mapped yet, and nothing stays"),
            _ => {}
        }
    } else if let Some(place) = &now.complete {
        note!("interrupted: {} is complete", place.display());
    }
    for path in now.temporary.drain(..) {
        let _ = if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
    }
    leave(signal)
}

/// Takes a bar away for good; whether there was one.
fn clear(bar: Option<ProgressBar>) -> bool {
    let Some(bar) = bar.filter(|b| !b.is_hidden() && !b.is_finished()) else { return false };
    bar.finish_and_clear();
    // Others may still move it.
    bar.set_draw_target(indicatif::ProgressDrawTarget::hidden());
    true
}

/// Calls `come` with each signal that comes.
#[cfg(unix)]
fn signals(mut come: impl FnMut(i32)) {
    use signal_hook::consts::{SIGINT, SIGTERM};
    if let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) {
        signals.forever().for_each(&mut come);
    }
}

/// Ends the process. Not by `exit`: what drivers and threads do there at the end, while others run, may hang or crash.
#[cfg(unix)]
fn leave(signal: i32) {
    signal_hook::low_level::exit(SIGNALLED + signal);
}

#[cfg(not(unix))]
fn signals(mut come: impl FnMut(i32)) {
    let Ok(runtime) = tokio::runtime::Builder::new_current_thread().enable_all().build() else { return };
    while runtime.block_on(tokio::signal::ctrl_c()).is_ok() {
        come(2);
    }
}

#[cfg(not(unix))]
fn leave(signal: i32) {
    std::process::exit(SIGNALLED + signal);
}
