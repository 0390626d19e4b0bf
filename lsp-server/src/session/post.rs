//! Messages to the writer from the work that it has started.

use std::sync::Arc;

use tokio::sync::mpsc::WeakUnboundedSender;

/// A sender of messages of one kind, into a queue of events. It does not keep the queue alive: messages after
/// the end of the queue are lost.
pub(crate) struct Post<T>(Arc<dyn Fn(T) + Send + Sync>);

impl<T> Clone for Post<T> {
    fn clone(&self) -> Post<T> {
        Post(self.0.clone())
    }
}

impl<T> Post<T> {
    /// A sender of messages that convert to the events of `queue`.
    pub(crate) fn new<E: From<T> + Send + 'static>(queue: &WeakUnboundedSender<E>) -> Post<T> {
        let queue = queue.clone();
        Post(Arc::new(move |message| {
            if let Some(queue) = queue.upgrade() {
                // Fails only after the end of the receiver.
                let _ = queue.send(E::from(message));
            }
        }))
    }

    pub(crate) fn send(&self, message: T) {
        (self.0)(message);
    }
}
