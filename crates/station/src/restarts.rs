//! Threads that are started, and started again after they have ended. The system may give no thread for a while.

use std::collections::BTreeSet;
use std::io;

/// Remembers the threads that could not be started, so that each failure is reported once.
#[derive(Debug, Default)]
pub struct Restarts {
    failed: BTreeSet<String>,
}

impl Restarts {
    /// The thread, or none if the system does not give it; and a sentence if that has changed since the last attempt. `name` is the
    /// beginning of the sentence. The caller tries again.
    pub fn attempt<T>(&mut self, name: &str, started: io::Result<T>) -> (Option<T>, Option<String>) {
        match started {
            Ok(thread) => (Some(thread), self.failed.remove(name).then(|| format!("{name} is started"))),
            Err(error) => {
                let sentence = format!("{name} cannot be started: {error}; the station tries again");
                (None, self.failed.insert(name.to_owned()).then_some(sentence))
            }
        }
    }

    /// Replaces each thread that has ended. One that the system does not give stays in the list and is tried again at the next call.
    /// Returns sentences about what has changed.
    pub fn replace_ended<T>(
        &mut self,
        threads: &mut [T],
        has_ended: impl Fn(&T) -> bool,
        name: impl Fn(&T) -> String,
        mut start: impl FnMut(&T) -> io::Result<T>,
    ) -> Vec<String> {
        let mut sentences = Vec::new();
        for thread in threads.iter_mut().filter(|thread| has_ended(thread)) {
            let name = name(thread);
            let (started, sentence) = self.attempt(&name, start(thread));
            if let Some(started) = started {
                *thread = started;
                sentences.push(format!("{name} has ended and is restarted"));
            } else {
                sentences.extend(sentence);
            }
        }
        sentences
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of its start, and whether it has ended.
    type Thread = (u32, bool);

    fn none() -> io::Error {
        io::Error::from(io::ErrorKind::WouldBlock)
    }

    #[test]
    fn a_thread_that_the_system_does_not_give_stays_and_is_tried_again_and_reported_once() {
        let mut restarts = Restarts::default();
        let mut threads: Vec<Thread> = vec![(1, false), (2, true), (3, true)];
        let name = |thread: &Thread| format!("thread {}", thread.0);
        let refused = |thread: &Thread| if thread.0 == 2 { Err(none()) } else { Ok((thread.0, false)) };
        let first = restarts.replace_ended(&mut threads, |thread| thread.1, name, refused);
        assert_eq!(threads, [(1, false), (2, true), (3, false)]);
        assert_eq!(first.len(), 2, "{first:?}");
        assert!(first[0].starts_with("thread 2 cannot be started: "), "{first:?}");
        assert!(first[0].ends_with("; the station tries again"), "{first:?}");
        assert_eq!(first[1], "thread 3 has ended and is restarted");
        let again = restarts.replace_ended(&mut threads, |thread| thread.1, name, refused);
        assert_eq!((again.as_slice(), threads[1]), (&[][..], (2, true)), "it was reported");
        let given = restarts.replace_ended(&mut threads, |thread| thread.1, name, |thread| Ok((thread.0, false)));
        assert_eq!(
            (given.as_slice(), threads[1]),
            (&["thread 2 has ended and is restarted".to_owned()][..], (2, false))
        );
    }

    #[test]
    fn a_new_thread_is_reported_only_if_it_was_not_given_at_first() {
        let mut restarts = Restarts::default();
        assert_eq!(restarts.attempt("the thread of segment hall", Ok(1)), (Some(1), None));
        let (thread, sentence) = restarts.attempt::<u32>("the thread of segment hall", Err(none()));
        assert_eq!(thread, None);
        assert!(sentence.unwrap().starts_with("the thread of segment hall cannot be started: "));
        assert_eq!(restarts.attempt::<u32>("the thread of segment hall", Err(none())), (None, None));
        let sentence = Some("the thread of segment hall is started".to_owned());
        assert_eq!(restarts.attempt("the thread of segment hall", Ok(2)), (Some(2), sentence));
    }
}
