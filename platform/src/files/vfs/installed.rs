//! The installed GenoM3: by the version file next to the templates in use, else by its package.

use camino::Utf8PathBuf;
use dotgen_analysis::release::{ReleaseChoice, ReleaseOrigin};
use dotgen_codegen::command::search_path;
use dotgen_codegen::template::discover;

use super::PackageConfig;
use super::{pkg_config, pkg_file};

const PACKAGE: &str = "genom3";

pub(super) fn release(config: &PackageConfig) -> Option<ReleaseChoice> {
    let configured = config.templates.iter().map(|template| template.clone().into_std_path_buf());
    // The settings replace the list of templates in the environment. The built-in folder is always searched.
    let search = search_path(None, &|name| std::env::var(name).ok());
    let mut templates: Vec<std::path::PathBuf> = configured.collect();
    if templates.is_empty() {
        templates = search.dirs;
    }
    templates.extend(search.builtin);
    if let Some((release, file)) = discover::release_of(&crate::files::disk::SystemDisk, &templates)
    {
        let file = Utf8PathBuf::from_path_buf(file).unwrap_or_default();
        return Some(ReleaseChoice { release, origin: ReleaseOrigin::Templates(file) });
    }
    let directories = pkg_file::search_path(&config.paths);
    let version = pkg_file::version(&directories, PACKAGE);
    // The tool may search more directories.
    let version = version.or_else(|| pkg_config::version(config, PACKAGE))?;
    Some(ReleaseChoice { release: version.parse().ok()?, origin: ReleaseOrigin::Package })
}
