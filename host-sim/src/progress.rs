//! A bar on the terminal while a computation runs.

use std::io::{IsTerminal, Write, stderr};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time between two drawings of the bar.
const PERIOD: Duration = Duration::from_millis(50);
/// Width of the bar, characters.
const WIDTH: usize = 40;
/// The longest message, characters, so that a line stays within a terminal.
const LONGEST: usize = 60;

/// A progress bar on the standard error. If that is no terminal, nothing is drawn.
pub struct Progress {
    shown: bool,
    begin: Instant,
    state: Mutex<State>,
}

struct State {
    message: String,
    done: u64,
    steps: u64,
    drawn: Option<Instant>,
}

impl Progress {
    /// A bar of so many steps; with none, its message alone is shown.
    pub fn new(message: &str, steps: u64) -> Self {
        Self {
            shown: stderr().is_terminal(),
            begin: Instant::now(),
            state: Mutex::new(State {
                message: message.to_owned(),
                done: 0,
                steps,
                drawn: None,
            }),
        }
    }

    /// Sets how many of how many steps are done.
    pub fn set(&self, done: u64, steps: u64) {
        self.change(|state| (state.done, state.steps) = (done, steps));
    }

    /// Sets what is being done.
    pub fn set_message(&self, message: String) {
        self.change(|state| state.message = message);
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.write("\r\x1b[K");
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut state);
        if self.shown && state.is_due(Instant::now()) {
            self.write(&format!("\r{}\x1b[K", state.line(self.begin.elapsed())));
        }
    }

    /// A terminal that cannot be written to is no reason to end the computation.
    fn write(&self, text: &str) {
        if self.shown {
            let _ = stderr().lock().write_all(text.as_bytes());
        }
    }
}

impl State {
    /// Whether to draw at `now`: at most once a [`PERIOD`].
    fn is_due(&mut self, now: Instant) -> bool {
        let due = self.drawn.is_none_or(|drawn| now - drawn >= PERIOD);
        if due {
            self.drawn = Some(now);
        }
        due
    }

    fn line(&self, elapsed: Duration) -> String {
        let message: String = self.message.chars().take(LONGEST).collect();
        if self.steps == 0 {
            return message;
        }
        let share = (self.done as f64 / self.steps as f64).min(1.0);
        let bar = "█".repeat((share * WIDTH as f64) as usize);
        let left = match self.done {
            0 => String::new(),
            _ => short(elapsed.as_secs_f64() * (1.0 / share - 1.0)),
        };
        format!(
            "{message:20} {bar:░<WIDTH$} {:>3.0} % {left:>4}",
            100.0 * share
        )
    }
}

/// Seconds in the largest unit of which there is one.
fn short(seconds: f64) -> String {
    match seconds {
        s if s < 60.0 => format!("{s:.0}s"),
        s if s < 3600.0 => format!("{:.0}m", s / 60.0),
        s => format!("{:.0}h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_the_share_that_is_done_and_the_time_that_is_left() {
        let mut state = State {
            message: "beamforming".into(),
            done: 250,
            steps: 1000,
            drawn: None,
        };
        let line = state.line(Duration::from_secs(10));
        let bar = "█".repeat(10) + &"░".repeat(30);
        assert_eq!(line, format!("beamforming          {bar}  25 %  30s"));
        state.done = 1;
        assert!(state.line(Duration::from_secs(10)).ends_with("  0 %   3h"));
        state.done = 250;
        assert!(state.line(Duration::from_secs(100)).ends_with(" 25 %   5m"));
        state.done = 0;
        assert!(state.line(Duration::ZERO).ends_with("  0 %     "));
        state.done = 2000;
        assert!(state.line(Duration::ZERO).ends_with("100 %   0s"));
        state.steps = 0;
        assert_eq!(state.line(Duration::ZERO), "beamforming");
    }

    #[test]
    fn the_bar_knows_its_state_and_is_drawn_once_a_period() {
        let progress = Progress::new("reading", 3);
        progress.set(1, 4);
        progress.set_message("writing".into());
        let mut state = progress.state.into_inner().unwrap();
        assert_eq!(
            (&state.message[..], state.done, state.steps),
            ("writing", 1, 4)
        );
        let begin = Instant::now();
        state.drawn = None;
        assert!(state.is_due(begin));
        assert!(!state.is_due(begin + PERIOD / 2));
        assert!(state.is_due(begin + PERIOD));
        assert!(!state.is_due(begin + PERIOD + PERIOD / 2));
    }
}
