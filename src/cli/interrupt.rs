//! Ctrl-C and SIGTERM: the command ends at once, removes temporary files, and says what stays. A second signal ends it without
//! cleaning up.
//!
//! A thread of its own handles the signals. Work that must not be interrupted, such as the renaming of a finished map, holds the guard
//! of [`defer_signals`]: the first signal waits for it.

use super::exit::SIGNALLED;
use super::print_note;
use crate::output::{begun, discard};
use indicatif::{ProgressBar, WeakProgressBar};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

/// Held while signals are deferred.
static GATE: Mutex<()> = Mutex::new(());
/// Whether a signal was received.
static RECEIVED: AtomicBool = AtomicBool::new(false);
static STATE: Mutex<State> = Mutex::new(State { bar: None, temporary: Vec::new(), output: None, complete: None });

/// What a signal has to clean up.
struct State {
    /// The progress bar that was shown last; weak, so that it ends with its owner.
    bar: Option<WeakProgressBar>,
    /// Files and folders to remove.
    temporary: Vec<PathBuf>,
    output: Option<Output>,
    /// The finished map.
    complete: Option<PathBuf>,
}

/// An unfinished map's folder.
struct Output {
    partial: PathBuf,
    /// The folders above it that were created for it, the innermost first.
    created_parents: Vec<PathBuf>,
    /// Whether `--resume` can go on with it.
    resumable: bool,
    /// Whether chunks are being written, so that the folder stays.
    writing: bool,
}

/// Signals are deferred while this lives.
pub type SignalGuard = MutexGuard<'static, ()>;

/// Defers signals until the guard is dropped.
pub fn defer_signals() -> SignalGuard {
    GATE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn state() -> MutexGuard<'static, State> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Registers a bar that is on the screen: messages are printed above it.
pub fn register_bar(bar: &ProgressBar) {
    state().bar = Some(bar.downgrade());
}

/// Prints something while a bar may be on the screen: the bar is removed and drawn again.
pub fn suspend_bar(print: impl FnOnce()) {
    // The holder of the lock has removed the bar.
    let bar = STATE.try_lock().ok().and_then(|state| state.bar.as_ref()?.upgrade());
    match bar.filter(|b| !b.is_finished()) {
        Some(bar) => bar.suspend(print),
        None => print(),
    }
}

/// Registers a file or a folder that is removed when a signal ends the command.
pub fn register_temporary(path: &Path) {
    state().temporary.push(path.into());
}

/// The folders above `path` that are not there yet, the innermost first.
pub fn missing_parents(path: &Path) -> Vec<PathBuf> {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
    path.ancestors().skip(1).take_while(|a| !a.exists()).map(PathBuf::from).collect()
}

/// Registers the folder `partial` of an unfinished map. `created_parents`: the folders above it that were created for it, the innermost
/// first. `resumable`: `--resume` can go on with it.
pub fn register_output(partial: &Path, created_parents: Vec<PathBuf>, resumable: bool) {
    state().output = Some(Output { partial: partial.into(), created_parents, resumable, writing: false });
}

/// Marks that the map's chunks are being written.
pub fn mark_writing() {
    let _guard = defer_signals();
    if let Some(output) = &mut state().output {
        output.writing = true;
    }
}

/// Marks that the map is finished, and lies in `place`. Where a signal waits this doesn't return: the process ends.
pub fn mark_finished(place: &Path, guard: SignalGuard) {
    let mut state = state();
    (state.output, state.complete) = (None, Some(place.into()));
    drop((state, guard));
    while RECEIVED.load(Ordering::SeqCst) {
        std::thread::park();
    }
}

/// Starts the thread that handles the signals. Where it can't start they end the process, as by default.
pub fn listen() {
    let _ = std::thread::Builder::new().name("signals".into()).spawn(|| {
        for_each_signal(|signal| {
            if RECEIVED.swap(true, Ordering::SeqCst) {
                exit_by(signal);
            }
            std::thread::spawn(move || shut_down(signal));
        });
    });
}

/// Waits for work that defers signals, cleans up, says what stays, and ends the process.
fn shut_down(signal: i32) {
    if !clear_bar(state().bar.take().and_then(|bar| bar.upgrade())) && std::io::stderr().is_terminal() {
        // The terminal shows ^C.
        let _ = writeln!(std::io::stderr());
    }
    let _guard = match GATE.try_lock() {
        Ok(guard) => guard,
        Err(TryLockError::Poisoned(e)) => e.into_inner(),
        Err(TryLockError::WouldBlock) => {
            print_note!("interrupted: the files under way are being finished; Ctrl-C again ends it at once");
            defer_signals()
        }
    };
    let mut state = state();
    clear_bar(state.bar.take().and_then(|bar| bar.upgrade()));
    if let Some(output) = state.output.take() {
        let stays = output.writing || begun(&output.partial);
        if !stays {
            discard(&output.partial);
            // Folders that hold anything else stay: `remove_dir` removes empty ones only.
            output.created_parents.iter().take_while(|folder| std::fs::remove_dir(folder).is_ok()).count();
        }
        match (stays, output.resumable) {
            (true, true) => print_note!(
                "interrupted: the unfinished map stays in {}; give the same command with --resume to go on with it, or with \
                 --overwrite to begin anew",
                output.partial.display()
            ),
            (false, true) => print_note!("interrupted: nothing was mapped yet, and nothing stays"),
            _ => {}
        }
    } else if let Some(place) = &state.complete {
        print_note!("interrupted: {} is complete", place.display());
    }
    for path in state.temporary.drain(..) {
        let _ = if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
    }
    exit_by(signal)
}

/// Removes a bar from the screen; whether there was one.
fn clear_bar(bar: Option<ProgressBar>) -> bool {
    let Some(bar) = bar.filter(|b| !b.is_hidden() && !b.is_finished()) else { return false };
    bar.finish_and_clear();
    // Its owner may still advance it.
    bar.set_draw_target(indicatif::ProgressDrawTarget::hidden());
    true
}

/// Calls `receive` with each signal.
#[cfg(unix)]
fn for_each_signal(mut receive: impl FnMut(i32)) {
    use signal_hook::consts::{SIGINT, SIGTERM};
    if let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) {
        signals.forever().for_each(&mut receive);
    }
}

/// Ends the process. Not by `exit`: the exit handlers of drivers may hang or crash while other threads run.
#[cfg(unix)]
fn exit_by(signal: i32) {
    signal_hook::low_level::exit(SIGNALLED + signal);
}

#[cfg(all(not(unix), feature = "view"))]
fn for_each_signal(mut receive: impl FnMut(i32)) {
    let Ok(runtime) = tokio::runtime::Builder::new_current_thread().enable_all().build() else { return };
    while runtime.block_on(tokio::signal::ctrl_c()).is_ok() {
        receive(2);
    }
}

/// Without a runtime for Ctrl-C it ends the process, as by default.
#[cfg(all(not(unix), not(feature = "view")))]
fn for_each_signal(_: impl FnMut(i32)) {}

#[cfg(not(unix))]
fn exit_by(signal: i32) {
    std::process::exit(SIGNALLED + signal);
}
