//! Files: as analysis sees them, as users have them, and packages.

pub mod disk;
pub mod vfs;
