//! Requests about a new component (docs/protocol.md).

use crate::features::component;
use crate::protocol::types::*;
use crate::session::backend::Backend;
use crate::session::dispatch::RequestScope;

impl Backend {
    /// `dotgen/interfaces`
    pub(crate) async fn interfaces(
        &self,
        params: component::NewComponentParams,
    ) -> Result<Vec<component::InterfaceInfo>> {
        self.dispatch
            .everywhere("Looking for interfaces", None, params, component::interfaces)
            .await
    }

    /// `dotgen/newComponent`
    pub(crate) async fn new_component(
        &self,
        params: component::NewComponentParams,
    ) -> Result<Option<component::NewFiles>> {
        let made =
            self.dispatch.anywhere(RequestScope::default(), params, component::new_component);
        made.await?.into_response()
    }
}
