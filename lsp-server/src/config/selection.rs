//! The selection of lenses and hints.

use dotgen_analysis::ide::{InlayConfig, InlayTypes, LensConfig};

use super::Settings;

impl Settings {
    /// The lenses to show: all, except those that are switched off.
    pub(crate) fn lens_config(&self) -> LensConfig {
        let on = |lens: Option<bool>| self.code_lens.unwrap_or(true) && lens.unwrap_or(true);
        LensConfig {
            verdicts: on(self.code_lens_verdicts),
            machines: on(self.code_lens_state_machines),
            accesses: on(self.code_lens_accesses),
            codels: on(self.code_lens_codels),
        }
    }

    /// True if lenses that run components and scenarios are shown.
    pub(crate) fn run_lenses(&self) -> bool {
        self.code_lens.unwrap_or(true) && self.code_lens_runs.unwrap_or(true)
    }

    /// The inlay hints to show: all, except those that are switched off. Types are shown only if they are
    /// inherited, unless all are switched on.
    pub(crate) fn inlay_config(&self) -> InlayConfig {
        let on = |setting: Option<bool>| setting.unwrap_or(true);
        InlayConfig {
            types: match (
                self.inlay_hints_all_types.unwrap_or(false),
                on(self.inlay_hints_inherited_types),
            ) {
                (true, _) => InlayTypes::All,
                (_, true) => InlayTypes::Inherited,
                _ => InlayTypes::Off,
            },
            implicit_ether: on(self.inlay_hints_implicit_ether),
            wcet: on(self.inlay_hints_wcet),
            utilisation: on(self.inlay_hints_utilisation),
            defaults: on(self.inlay_hints_defaults),
        }
    }
}
