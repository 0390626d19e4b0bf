//! The selection of lenses and hints.

use dotgen_analysis::ide::{InlayConfig, InlayTypes, LensConfig};

use super::Settings;

impl Settings {
    pub(super) fn code_lenses(&self) -> [Option<bool>; 6] {
        [
            self.code_lens,
            self.code_lens_verdicts,
            self.code_lens_state_machines,
            self.code_lens_accesses,
            self.code_lens_codels,
            self.code_lens_runs,
        ]
    }

    pub(super) fn code_lenses_mut(&mut self) -> [&mut Option<bool>; 6] {
        [
            &mut self.code_lens,
            &mut self.code_lens_verdicts,
            &mut self.code_lens_state_machines,
            &mut self.code_lens_accesses,
            &mut self.code_lens_codels,
            &mut self.code_lens_runs,
        ]
    }

    /// The lenses to show: all, except those that are switched off.
    pub(crate) fn lens_config(&self) -> LensConfig {
        let [any, verdicts, machines, accesses, codels, _] =
            self.code_lenses().map(|lens| lens.unwrap_or(true));
        LensConfig {
            verdicts: any && verdicts,
            machines: any && machines,
            accesses: any && accesses,
            codels: any && codels,
        }
    }

    /// True if lenses that run components and scenarios are shown.
    pub(crate) fn run_lenses(&self) -> bool {
        self.code_lens.unwrap_or(true) && self.code_lens_runs.unwrap_or(true)
    }

    pub(super) fn inlay_hints(&self) -> [Option<bool>; 6] {
        [
            self.inlay_hints_inherited_types,
            self.inlay_hints_all_types,
            self.inlay_hints_implicit_ether,
            self.inlay_hints_wcet,
            self.inlay_hints_utilisation,
            self.inlay_hints_defaults,
        ]
    }

    pub(super) fn inlay_hints_mut(&mut self) -> [&mut Option<bool>; 6] {
        [
            &mut self.inlay_hints_inherited_types,
            &mut self.inlay_hints_all_types,
            &mut self.inlay_hints_implicit_ether,
            &mut self.inlay_hints_wcet,
            &mut self.inlay_hints_utilisation,
            &mut self.inlay_hints_defaults,
        ]
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
