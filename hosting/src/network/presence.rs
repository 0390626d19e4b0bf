//! The components of this run, as other machines see them, and those of other machines.

use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicUsize, Ordering};

use dotgen_timing::system::ComponentId;
use zenoh::liveliness::LivelinessToken;
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait as _};

use super::Notifier;
use crate::components::KnownComponent;
use crate::remote::{RemoteComponents, host_name};

/// The first word of the keys of tokens. Because of its `@`, no wildcard of a port matches it.
const TOKENS: &str = "@dotgen";

/// Number of changes that are reported: a machine that appears and disappears all the time fills no log.
const MAX_NOTES: usize = 1_000;

/// The tokens of the components of this run. Zenoh reports a token as gone when it is dropped, when its
/// process ends, or when its machine is silent for the lease of the transport.
pub(super) type Tokens = HashMap<ComponentId, LivelinessToken>;

/// Declares the tokens `@dotgen/SESSION/HOST/COMPONENT`.
pub(super) fn declare(
    session: &Session,
    known: &BTreeMap<ComponentId, KnownComponent>,
) -> zenoh::Result<Tokens> {
    let (id, host) = (session.zid(), host_name());
    // Characters with a meaning in keys.
    let host = match host.replace(['/', '*', '$', '?', '#', '@'], "_") {
        host if host.is_empty() => "_".to_owned(),
        host => host,
    };
    let tokens = known.iter().map(|(&component, entry)| {
        let key = format!("{TOKENS}/{id}/{host}/{}", entry.component().name);
        Ok((component, session.liveliness().declare_token(key).wait()?))
    });
    tokens.collect()
}

/// Follows the components of other machines until the session ends, and reports each that appears or
/// disappears.
pub(super) fn follow(
    session: &Session,
    remote: &RemoteComponents,
    tell: &Notifier,
) -> zenoh::Result<()> {
    let (own, remote, tell) = (session.zid().to_string(), remote.clone(), tell.clone());
    let notes = AtomicUsize::new(0);
    let all = session.liveliness().declare_subscriber(format!("{TOKENS}/*/*/*"));
    let all = all.history(true).callback(move |sample| {
        let mut words = sample.key_expr().split('/').skip(1);
        let (Some(session), Some(host), Some(component)) =
            (words.next(), words.next(), words.next())
        else {
            return;
        };
        let provides = sample.kind() == SampleKind::Put;
        if session != own && remote.set(host, component, session, provides) {
            let what = if provides { "has appeared" } else { "has disappeared" };
            match notes.fetch_add(1, Ordering::Relaxed) {
                ..MAX_NOTES => tell(&format!("`{component}` of the machine `{host}` {what}")),
                MAX_NOTES => tell("further changes of other machines are only in `progress`"),
                _ => {}
            }
        }
    });
    all.background().wait()
}
