//! Concurrent answers to many questions.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use crate::cancel::Cancel;

/// Answers all questions, up to `together` of them concurrently. `begin` gets each question that is started,
/// with the number of answers so far. `tell` gets the answers in the order of the questions, each as soon as
/// all earlier answers are known, so that the output does not depend on the number of threads. After a
/// cancellation no further question is started. Answers given until then are still passed to `tell`.
pub(crate) fn all<Q: Sync, A: Send + Sync>(
    questions: &[Q],
    together: usize,
    cancel: &Cancel,
    begin: &(dyn Fn(usize, &Q) + Sync),
    ask: &(dyn Fn(&Q) -> A + Sync),
    tell: &(dyn Fn(&A) + Sync),
) -> Vec<Option<A>> {
    let answers: Vec<OnceLock<A>> = questions.iter().map(|_| OnceLock::new()).collect();
    let (next, done, told) = (AtomicUsize::new(0), Mutex::new(0), Mutex::new(0));
    let work = || {
        while !cancel.is_over() {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some(question) = questions.get(at) else {
                break;
            };
            // `begin` is called under the lock, so that the number of answers never seems to decrease.
            let so_far = lock(&done);
            begin(*so_far, question);
            drop(so_far);
            answers[at].get_or_init(|| ask(question));
            *lock(&done) += 1;
            let mut told = lock(&told);
            while let Some(answer) = answers.get(*told).and_then(OnceLock::get) {
                tell(answer);
                *told += 1;
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..together {
            scope.spawn(work);
        }
        work();
    });
    let told = *lock(&told);
    let answers: Vec<Option<A>> = answers.into_iter().map(OnceLock::into_inner).collect();
    answers[told.min(answers.len())..].iter().flatten().for_each(tell);
    answers
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
