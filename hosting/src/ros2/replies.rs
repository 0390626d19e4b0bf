//! Requests of ROS 2 clients, and the thread that replies.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use dotgen_ros2::wire::Attachment;
use zenoh::Wait as _;
use zenoh::query::Query;

use super::topics::nanoseconds;
use crate::clients::MAX_REQUEST_BYTES;

/// Replies that have not been sent. Further ones are lost: their clients get none.
const QUEUED: usize = 1024;

/// A request that waits for its reply.
pub(super) struct Asked {
    query: Query,
    key: String,
    attachment: Attachment,
}

impl Asked {
    /// A request to an endpoint with a key, and its payload. A request with an error is answered by it.
    pub(super) fn read(query: Query, key: &str, replies: &Replies) -> Option<(Asked, Vec<u8>)> {
        let attachment = query.attachment().filter(|attachment| attachment.len() <= 64);
        let attachment = attachment.and_then(|attachment| Attachment::read(&attachment.to_bytes()));
        let payload = query.payload().filter(|payload| payload.len() <= MAX_REQUEST_BYTES);
        let payload = payload.map(|payload| payload.to_bytes().into_owned());
        match (attachment, payload) {
            (Some(attachment), Some(payload)) => {
                let key = key.to_owned();
                let asked = Asked { query, key, attachment };
                Some((asked, payload))
            }
            (None, _) => {
                let why = "the attachment is not a sequence number, a time and a GID of 16 bytes";
                replies.refuse(query, why.to_owned());
                None
            }
            (_, None) => {
                let why = format!("a request has a payload of at most {MAX_REQUEST_BYTES} bytes");
                replies.refuse(query, why);
                None
            }
        }
    }
}

/// A reply that is to be sent.
enum Reply {
    Payload(Asked, Vec<u8>),
    Error(Query, String),
}

/// The replies to clients. A client that does not read its replies holds up those to others at most until
/// Zenoh closes the connection. The engine never waits.
#[derive(Clone)]
pub(super) struct Replies(SyncSender<Reply>);

impl Replies {
    /// Starts the thread, which ends with the last copy.
    pub(super) fn new() -> Replies {
        let (sender, queue) = sync_channel(QUEUED);
        std::thread::spawn(move || send(&queue));
        Replies(sender)
    }

    /// Replies with a payload.
    pub(super) fn send(&self, to: Asked, payload: Vec<u8>) {
        let _ = self.0.try_send(Reply::Payload(to, payload));
    }

    /// Replies with an error in words.
    pub(super) fn error(&self, to: Asked, why: String) {
        self.refuse(to.query, why);
    }

    fn refuse(&self, to: Query, why: String) {
        let _ = self.0.try_send(Reply::Error(to, why));
    }
}

fn send(queue: &Receiver<Reply>) {
    for reply in queue {
        // The client may be gone.
        let _ = match reply {
            Reply::Payload(to, payload) => {
                let attachment = Attachment { time: nanoseconds(), ..to.attachment };
                let reply = to.query.reply(to.key, payload);
                reply.attachment(&attachment.to_bytes()[..]).wait()
            }
            Reply::Error(to, why) => to.reply_err(why).wait(),
        };
    }
}
