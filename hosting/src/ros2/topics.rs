//! Publishers, and the data sent with each message.

use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use dotgen_ros2::cdr::Stamp;
use dotgen_ros2::node::Endpoint;
use dotgen_ros2::wire::{Attachment, NodeId, Qos, gid};
use zenoh::liveliness::LivelinessToken;
use zenoh::{Session, Wait as _};
use zenoh_ext::{AdvancedPublisher, AdvancedPublisherBuilderExt as _, CacheConfig};

/// A publisher of a node, which is in the graph until it is dropped.
pub(super) struct Topic {
    publisher: AdvancedPublisher<'static>,
    gid: [u8; 16],
    sent: AtomicI64,
    _token: LivelinessToken,
}

impl Topic {
    /// Declares a publisher, by its node and its number in the session.
    pub(super) fn new(
        session: &Session,
        node: NodeId<'_>,
        endpoint: &Endpoint,
        number: u32,
    ) -> zenoh::Result<Topic> {
        let token = endpoint.token(node, number);
        let publisher = session.declare_publisher(endpoint.key(node.domain));
        let publisher = match endpoint.qos {
            Qos::Latched => {
                publisher.cache(CacheConfig::default().max_samples(1)).publisher_detection()
            }
            Qos::Volatile => publisher.advanced(),
        };
        Ok(Topic {
            publisher: publisher.wait()?,
            gid: gid(&token),
            sent: AtomicI64::new(0),
            _token: session.liveliness().declare_token(token).wait()?,
        })
    }

    /// Publishes a message. A slow reader misses it: nothing waits.
    pub(super) fn put(&self, message: Vec<u8>) {
        let attachment = Attachment {
            sequence: self.sent.fetch_add(1, Ordering::Relaxed) + 1,
            time: nanoseconds(),
            gid: self.gid,
        };
        let put = self.publisher.put(message);
        let _ = put.attachment(&attachment.to_bytes()[..]).wait();
    }
}

/// The time since 1970.
pub(super) fn nanoseconds() -> i64 {
    let time = SystemTime::now().duration_since(UNIX_EPOCH);
    time.map_or(0, |time| i64::try_from(time.as_nanos()).unwrap_or(i64::MAX))
}

/// The time since 1970.
pub(super) fn now() -> Stamp {
    let time = nanoseconds();
    Stamp {
        sec: i32::try_from(time / 1_000_000_000).unwrap_or(i32::MAX),
        nanosec: (time % 1_000_000_000) as u32,
    }
}
