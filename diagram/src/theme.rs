//! Colours, by role.

use serde::{Deserialize, Serialize};

/// The colours of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Theme {
    /// Light, or dark if the viewer prefers it (`prefers-color-scheme`). For files.
    #[default]
    Auto,
    /// Dark text on light ground.
    Light,
    /// Light text on dark ground.
    Dark,
    /// Greys without a background: for images in an editor of any theme.
    Neutral,
    /// As `Light`, without a background: for images in an editor with a light theme.
    LightClear,
    /// As `Dark`, without a background.
    DarkClear,
    /// The variables of a VS Code webview, so that the picture follows the editor's theme, high
    /// contrast included.
    Editor,
}

/// One colour for each role.
struct Palette {
    ink: &'static str,
    faint: &'static str,
    ground: &'static str,
    fill: &'static str,
    accent: &'static str,
    warn: &'static str,
    error: &'static str,
    heat: &'static str,
}

const LIGHT: Palette = Palette {
    ink: "#1f2328",
    faint: "#656d76",
    ground: "#ffffff",
    fill: "#f6f8fa",
    accent: "#0550ae",
    warn: "#8a5a00",
    error: "#c0392b",
    heat: "#e8590c",
};

const DARK: Palette = Palette {
    ink: "#e6edf3",
    faint: "#9198a1",
    ground: "#1e1e1e",
    fill: "#2a2d31",
    accent: "#79b8ff",
    warn: "#e3b341",
    error: "#ff7b72",
    heat: "#ff8c42",
};

const NEUTRAL: Palette = Palette {
    ink: "#7f7f7f",
    faint: "#868686",
    ground: "none",
    fill: "#80808022",
    accent: "#3b82d0",
    warn: "#b07d00",
    error: "#d64541",
    heat: "#e8590c",
};

const EDITOR: Palette = Palette {
    ink: "var(--vscode-editor-foreground)",
    faint: "var(--vscode-descriptionForeground)",
    ground: "var(--vscode-editor-background)",
    fill: "var(--vscode-editorWidget-background)",
    accent: "var(--vscode-textLink-foreground)",
    warn: "var(--vscode-editorWarning-foreground)",
    error: "var(--vscode-editorError-foreground)",
    heat: "var(--vscode-charts-orange)",
};

impl Theme {
    /// Returns true if pictures have no background.
    pub(crate) fn is_clear(self) -> bool {
        matches!(self, Theme::LightClear | Theme::DarkClear | Theme::Neutral)
    }
}

/// The end of the style sheet of a picture that becomes an image: its fonts have one weight each.
#[cfg(feature = "png")]
pub(crate) const RASTER_STYLE: &str = ".title{font-weight:400}\n</style>";

/// A palette without a background.
const fn clear(of: Palette) -> Palette {
    Palette { ground: "none", fill: "#80808018", ..of }
}

const LIGHT_CLEAR: Palette = clear(LIGHT);
const DARK_CLEAR: Palette = clear(DARK);

/// The style sheet of a picture.
pub(crate) fn style(theme: Theme) -> String {
    in_colours(theme, rules)
}

/// The additional rules of pictures with marked elements: a path, a chain, a lock.
pub(crate) fn mark_style(theme: Theme) -> String {
    in_colours(theme, mark_rules)
}

fn in_colours(theme: Theme, rules: fn(&Palette) -> String) -> String {
    match theme {
        Theme::Light => rules(&LIGHT),
        Theme::Neutral => rules(&NEUTRAL),
        Theme::Dark => rules(&DARK),
        Theme::LightClear => rules(&LIGHT_CLEAR),
        Theme::DarkClear => rules(&DARK_CLEAR),
        Theme::Editor => rules(&EDITOR),
        Theme::Auto => {
            format!("{}@media (prefers-color-scheme:dark){{\n{}}}\n", rules(&LIGHT), rules(&DARK))
        }
    }
}

fn mark_rules(p: &Palette) -> String {
    let Palette { accent, warn, .. } = p;
    format!(
        ".contended .shape{{stroke:{warn};stroke-width:1.8}}\n\
         .marked .shape{{stroke:{accent};stroke-width:2.6}}\n\
         .marked .line{{stroke:{accent};stroke-width:2.6}}\n\
         .marked .head{{fill:{accent};stroke:{accent}}}\n"
    )
}

fn rules(p: &Palette) -> String {
    let Palette { ink, faint, ground, fill, accent, warn, error, heat } = p;
    let mut out = format!(
        "text{{fill:{ink};font:11px system-ui,'Segoe UI',Ubuntu,'DejaVu Sans',sans-serif}}\n\
         .ground{{fill:{ground}}}\n\
         .title{{font-size:13px;font-weight:600}}\n\
         .code{{font-family:ui-monospace,'Cascadia Mono',Hack,'DejaVu Sans Mono',monospace;fill:{faint}}}\n\
         .detail,.note{{fill:{faint}}}\n\
         .shape{{fill:{fill};stroke:{ink};stroke-width:1.2}}\n\
         .frame{{fill:none;stroke:{faint};stroke-width:1;opacity:.55}}\n\
         .rule{{stroke:{ink};stroke-width:.8;opacity:.4}}\n\
         .mark{{fill:{ink};stroke:{ink}}}\n\
         .ring{{fill:{ground};stroke:{ink};stroke-width:2}}\n\
         .line{{fill:none;stroke:{ink};stroke-width:1.2}}\n\
         .head{{fill:{ink}}}\n\
         .edge .label{{fill:{faint};stroke:{ground};stroke-width:4px;stroke-linejoin:round;paint-order:stroke}}\n\
         .paused .line{{stroke-dasharray:6 4;stroke:{accent}}}\n\
         .paused .head{{fill:{accent}}}\n\
         .paused .label{{fill:{accent}}}\n\
         .interrupt .line,.throw .line{{stroke-dasharray:2 3;stroke:{faint}}}\n\
         .interrupt .head,.throw .head{{fill:{faint}}}\n\
         .async .shape{{stroke-dasharray:9 3}}\n\
         .unreachable{{opacity:.45}}\n\
         .unreachable .shape{{stroke-dasharray:3 3}}\n\
         .undefined .shape{{stroke:{error};stroke-dasharray:4 3;fill:none}}\n\
         .undefined text{{fill:{error}}}\n\
         .port .shape{{fill:{ground};stroke:{accent}}}\n\
         .unconnected .shape{{stroke:{warn};stroke-dasharray:4 3}}\n\
         .unconnected text{{fill:{warn}}}\n\
         .data .shape{{fill:{ground};stroke:{warn}}}\n\
         .lock .line{{stroke:{faint}}}\n\
         .lock .head{{fill:{faint}}}\n\
         .writes .line{{stroke:{warn};stroke-width:1.8}}\n\
         .writes .head{{fill:{warn}}}\n\
         .selected .shape,.node:focus .shape{{stroke:{accent};stroke-width:2.6}}\n\
         .node:focus,.edge:focus{{outline:none}}\n\
         .edge:focus .line,.edge:hover .line{{stroke-width:2.4}}\n"
    );
    for level in 1..=5 {
        let opacity = f64::from(level) * 0.11;
        out.push_str(&format!(
            ".heat-{level} .heat{{fill:{heat};opacity:{opacity:.2}}}\n\
             .heat-{level} text{{fill:{ink}}}\n"
        ));
    }
    out
}
