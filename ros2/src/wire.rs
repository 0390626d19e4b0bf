//! Keys, liveliness tokens, attachments and ids of `rmw_zenoh`.

use xxhash_rust::xxh3::xxh3_128;

/// Bytes of an attachment.
pub const ATTACHMENT: usize = 33;

/// The kind of an endpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    Publisher,
    Subscription,
    Server,
    Client,
}

impl Kind {
    /// The letters in a token.
    fn letters(self) -> &'static str {
        match self {
            Kind::Publisher => "MP",
            Kind::Subscription => "MS",
            Kind::Server => "SS",
            Kind::Client => "SC",
        }
    }
}

/// The quality of service of an endpoint. All are reliable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Qos {
    /// `volatile`: a reader that joins later has no earlier data. Up to ten messages wait.
    Volatile,
    /// `transient_local`: a reader that joins later has the last message.
    Latched,
}

impl Qos {
    /// The text in a token.
    pub fn text(self) -> &'static str {
        match self {
            Qos::Volatile => "::,10:,:,:,,",
            Qos::Latched => ":1:,1:,:,:,,",
        }
    }
}

/// The name of a type in keys and tokens: `or_t3d::msg::dds_::Pos_`.
pub fn type_name(name: &str) -> String {
    match name.rsplit_once('/') {
        Some((package, local)) => format!("{}::dds_::{local}_", package.replace('/', "::")),
        None => name.to_owned(),
    }
}

/// The key of a topic or service.
pub fn key(domain: u32, topic: &str, type_name: &str, hash: &str) -> String {
    let topic = topic.trim_matches('/');
    format!("{domain}/{topic}/{}/{hash}", self::type_name(type_name))
}

/// A node of a Zenoh session.
#[derive(Debug, Clone, Copy)]
pub struct NodeId<'a> {
    /// The ROS domain.
    pub domain: u32,
    /// The id of the Zenoh session, in hexadecimal digits.
    pub session: &'a str,
    /// The number of the node. Nodes and endpoints of a session have different numbers.
    pub number: u32,
    /// The name of the node.
    pub name: &'a str,
}

impl NodeId<'_> {
    /// The liveliness token of the node.
    pub fn token(&self) -> String {
        self.start(self.number, "NN")
    }

    /// The liveliness token of an endpoint of the node with its own number.
    pub(crate) fn endpoint_token(
        &self,
        number: u32,
        kind: Kind,
        topic: &str,
        type_name: &str,
        hash: &str,
        qos: Qos,
    ) -> String {
        let start = self.start(number, kind.letters());
        let (topic, name) = (topic.replace('/', "%"), self::type_name(type_name));
        format!("{start}/{topic}/{name}/{hash}/{}", qos.text())
    }

    fn start(&self, number: u32, kind: &str) -> String {
        let NodeId { domain, session, number: node, name } = self;
        format!("@ros2_lv/{domain}/{session}/{node}/{number}/{kind}/%/%/{name}")
    }
}

/// The id of an endpoint in attachments, from its token.
pub fn gid(token: &str) -> [u8; 16] {
    xxh3_128(token.as_bytes()).to_le_bytes()
}

/// The data sent with each message, request and reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Attachment {
    /// The number of the message or request of its sender. A reply has the number of the request.
    pub sequence: i64,
    /// The time of sending, in nanoseconds since 1970.
    pub time: i64,
    /// The sender. A reply has the sender of the request.
    pub gid: [u8; 16],
}

impl Attachment {
    pub fn to_bytes(self) -> [u8; ATTACHMENT] {
        let mut out = [0; ATTACHMENT];
        out[..8].copy_from_slice(&self.sequence.to_le_bytes());
        out[8..16].copy_from_slice(&self.time.to_le_bytes());
        out[16] = 16;
        out[17..].copy_from_slice(&self.gid);
        out
    }

    /// Reads an attachment; `None` if the bytes are not one.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let (sequence, rest) = bytes.split_first_chunk()?;
        let (time, rest) = rest.split_first_chunk()?;
        let (&16, gid) = rest.split_first()? else {
            return None;
        };
        Some(Attachment {
            sequence: i64::from_le_bytes(*sequence),
            time: i64::from_le_bytes(*time),
            gid: gid.try_into().ok()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODE: NodeId<'_> = NodeId { domain: 0, session: "a1b2", number: 3, name: "pump" };

    #[test]
    fn keys_and_tokens_have_their_parts() {
        assert_eq!(
            key(7, "/pump/fill/_action/send_goal", "pump/action/Fill_SendGoal", "RIHS01_0"),
            "7/pump/fill/_action/send_goal/pump::action::dds_::Fill_SendGoal_/RIHS01_0"
        );
        assert_eq!(NODE.token(), "@ros2_lv/0/a1b2/3/3/NN/%/%/pump");
        let kind = Kind::Publisher;
        assert_eq!(
            NODE.endpoint_token(4, kind, "/pump/level", "pump/msg/Level", "RIHS01_0", Qos::Latched),
            "@ros2_lv/0/a1b2/3/4/MP/%/%/pump/%pump%level/pump::msg::dds_::Level_/RIHS01_0/:1:,1:,:,:,,"
        );
    }

    #[test]
    fn attachments_are_read_back_and_others_refused() {
        let attachment = Attachment { sequence: -2, time: 1_000_000_007, gid: gid(&NODE.token()) };
        let bytes = attachment.to_bytes();
        assert_eq!(bytes[..8], [0xfe, 255, 255, 255, 255, 255, 255, 255]);
        assert_eq!(Attachment::read(&bytes), Some(attachment));
        for end in 0..ATTACHMENT {
            assert_eq!(Attachment::read(&bytes[..end]), None, "{end}");
        }
        assert_eq!(Attachment::read(&[&bytes[..], &[0]].concat()), None);
        let mut other = bytes;
        other[16] = 15;
        assert_eq!(Attachment::read(&other), None);
    }

    /// The hash of the empty text is that of the definition of XXH3.
    #[test]
    fn ids_are_hashes_with_the_lower_half_first() {
        let empty = 0x99aa_06d3_0147_98d8_6001_c324_468d_497f_u128;
        assert_eq!(gid(""), empty.to_le_bytes());
    }
}
