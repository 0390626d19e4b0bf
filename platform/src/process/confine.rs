//! The confinement of this process and of the program it becomes. It cannot be undone.
//!
//! On Linux, Landlock limits files (and connections over TCP). seccomp refuses calls that start programs,
//! open connections, or change attributes that Landlock does not cover. Neither needs privileges.

use std::io;
use std::path::Path;

use dotgen_codegen::process::{Access, Gap, Resources};

#[cfg(target_os = "linux")]
pub(super) use linux::{confine, gaps};

/// Limits the resources of this process.
#[cfg(unix)]
pub(super) fn limit(resources: &Resources) -> io::Result<()> {
    use rustix::process::{Resource, Rlimit, setrlimit};
    let set = |what: Resource, value: u64| {
        let limit = Rlimit { current: Some(value), maximum: Some(value) };
        setrlimit(what, limit)
    };
    if *resources == Resources::default() {
        return Ok(());
    }
    set(Resource::Core, 0)?;
    if let Some(time) = resources.time {
        set(Resource::Cpu, time.as_secs() + 1)?;
    }
    if let Some(size) = resources.file {
        set(Resource::Fsize, size)?;
    }
    if let Some(memory) = resources.memory {
        set(Resource::As, memory)?;
    }
    Ok(())
}

#[cfg(not(unix))]
pub(super) fn limit(_: &Resources) -> io::Result<()> {
    Ok(())
}

/// Other systems have no confinement that remains after `exec`.
#[cfg(not(target_os = "linux"))]
pub(super) fn confine(_: &Access, _: Option<&Path>) -> io::Result<()> {
    Ok(())
}

#[cfg(not(target_os = "linux"))]
pub(super) fn gaps() -> Vec<Gap> {
    let mut gaps = vec![Gap::Files, Gap::Programs, Gap::Network];
    if !cfg!(unix) {
        gaps.push(Gap::Resources);
    }
    gaps
}

#[cfg(target_os = "linux")]
mod linux {
    use std::collections::BTreeMap;
    use std::path::PathBuf;
    use std::sync::LazyLock;

    use landlock::{
        ABI, Access as _, AccessFs, AccessNet, BitFlags, CompatLevel, Compatible, Ruleset,
        RulesetAttr, RulesetCreatedAttr, Scope, path_beneath_rules,
    };
    use seccompiler::{
        BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter,
        SeccompRule,
    };

    use super::*;

    /// The requested version of Landlock.
    const REQUESTED_ABI: ABI = ABI::V6;
    /// The minimum version of Landlock with which files count as confined: earlier versions allow truncation.
    const MIN_ABI: ABI = ABI::V3;

    /// See [`super::super::System`].
    pub(in super::super) fn gaps() -> Vec<Gap> {
        static GAPS: LazyLock<Vec<Gap>> = LazyLock::new(|| {
            let mut gaps = Vec::new();
            let files = Ruleset::default().set_compatibility(CompatLevel::HardRequirement);
            let files = files.handle_access(AccessFs::from_all(MIN_ABI)).and_then(Ruleset::create);
            if files.is_err() {
                gaps.push(Gap::Files);
            }
            // A filter applies to the thread that installs it. A thread that ends at once can test it.
            let tried = std::thread::spawn(|| install(Vec::new(), SeccompAction::Allow).is_ok());
            if !tried.join().unwrap_or(false) {
                gaps.extend([Gap::Programs, Gap::Network]);
            }
            gaps
        });
        GAPS.clone()
    }

    /// Confines this thread, which is the only one, and the program it becomes.
    pub(in super::super) fn confine(access: &Access, program: Option<&Path>) -> io::Result<()> {
        confine_files(access, program).map_err(io::Error::other)?;
        if gaps().contains(&Gap::Programs) {
            return Ok(());
        }
        // The filter that is installed first must not refuse calls that the next ones need.
        install(emulated(), SeccompAction::Errno(0))?;
        install(missing(), SeccompAction::Errno(libc::ENOSYS.cast_unsigned()))?;
        install(refused(program.is_none())?, SeccompAction::Errno(libc::EPERM.cast_unsigned()))
    }

    fn confine_files(
        access: &Access,
        program: Option<&Path>,
    ) -> Result<(), landlock::RulesetError> {
        let read: BitFlags<AccessFs> = AccessFs::ReadFile | AccessFs::ReadDir;
        let run = read | AccessFs::Execute;
        let program =
            program.map(|program| program.canonicalize().unwrap_or_else(|_| program.to_owned()));
        let (libraries, data) = program.as_deref().map(needed).unwrap_or_default();
        Ruleset::default()
            .handle_access(AccessFs::from_all(REQUESTED_ABI))?
            .handle_access(AccessNet::from_all(REQUESTED_ABI))?
            .scope(Scope::from_all(REQUESTED_ABI))?
            .create()?
            // Missing paths need no rule.
            .add_rules(path_beneath_rules(&access.read, read))?
            .add_rules(path_beneath_rules(&data, read))?
            .add_rules(path_beneath_rules(["/dev/null"], read | AccessFs::WriteFile))?
            .add_rules(path_beneath_rules(program.iter().chain(&libraries), run))?
            .add_rules(path_beneath_rules(&access.write, AccessFs::from_all(REQUESTED_ABI) & !AccessFs::Execute))?
            .restrict_self()?;
        Ok(())
    }

    /// Folders of libraries, including the dynamic loader, and files that Tcl reads.
    fn needed(program: &Path) -> (Vec<PathBuf>, Vec<PathBuf>) {
        let mut libraries: Vec<PathBuf> =
            ["/lib", "/lib32", "/lib64", "/usr/lib", "/usr/lib32", "/usr/lib64", "/usr/local/lib"]
                .map(PathBuf::from)
                .to_vec();
        let mut data: Vec<PathBuf> = [
            "/etc/ld.so.cache",
            "/etc/ld.so.preload",
            "/etc/localtime",
            "/etc/timezone",
            "/dev/urandom",
            "/usr/share/zoneinfo",
            "/usr/share/locale",
            "/usr/share/tcltk",
        ]
        .map(PathBuf::from)
        .to_vec();
        // An installation elsewhere has its library folder next to its programs.
        if let Some(prefix) = program.parent().and_then(Path::parent) {
            libraries.push(prefix.join("lib"));
            for name in ["share/tcltk", "share/tcl", "share/tcl8.6"] {
                data.push(prefix.join(name));
            }
            // Stores of packages: their content is public, and libraries may be anywhere in them.
            for store in ["/nix/store", "/gnu/store"] {
                if prefix.starts_with(store) {
                    libraries.push(store.into());
                }
            }
        }
        data.extend(std::env::var_os("TCL_LIBRARY").map(PathBuf::from));
        (libraries, data)
    }

    type Rules = Vec<(i64, Vec<SeccompRule>)>;

    fn install(rules: Rules, action: SeccompAction) -> io::Result<()> {
        let mut all: BTreeMap<i64, Vec<SeccompRule>> = BTreeMap::new();
        for (call, conditions) in rules {
            // On this architecture, programs with 32-bit pointers (x32) use other numbers for these calls.
            #[cfg(target_arch = "x86_64")]
            all.insert(call | 0x4000_0000, conditions.clone());
            all.insert(call, conditions);
        }
        let action =
            if all.is_empty() { SeccompAction::Errno(libc::EPERM.cast_unsigned()) } else { action };
        let architecture = std::env::consts::ARCH.try_into().map_err(io::Error::other)?;
        let filter = SeccompFilter::new(all, SeccompAction::Allow, action, architecture);
        let program: BpfProgram = filter.and_then(TryInto::try_into).map_err(io::Error::other)?;
        seccompiler::apply_filter(&program).map_err(io::Error::other)
    }

    fn all(calls: &[i64]) -> Rules {
        calls.iter().map(|call| (*call, Vec::new())).collect()
    }

    /// Changes of permissions and dates, which Landlock does not cover. They succeed without effect: Tcl
    /// copies them with a file, and would report a refusal as a failed copy.
    fn emulated() -> Rules {
        #[cfg_attr(
            not(target_arch = "x86_64"),
            expect(unused_mut, reason = "older calls are added")
        )]
        let mut calls =
            vec![libc::SYS_fchmod, libc::SYS_fchmodat, libc::SYS_fchmodat2, libc::SYS_utimensat];
        #[cfg(target_arch = "x86_64")]
        calls.extend([libc::SYS_chmod, libc::SYS_utime, libc::SYS_utimes, libc::SYS_futimesat]);
        all(&calls)
    }

    /// Calls that are reported as missing, because libraries can do without them. seccomp cannot read their
    /// arguments in memory.
    fn missing() -> Rules {
        all(&[libc::SYS_clone3, libc::SYS_io_uring_setup])
    }

    /// The refused calls.
    fn refused(programs: bool) -> io::Result<Rules> {
        let mut rules = all(FORBIDDEN_CALLS);
        #[cfg(target_arch = "x86_64")]
        rules.extend(all(&[
            libc::SYS_fork,
            libc::SYS_vfork,
            libc::SYS_mknod,
            libc::SYS_ioperm,
            libc::SYS_iopl,
        ]));
        #[cfg(target_arch = "x86_64")]
        rules.extend(all(&[libc::SYS_chown, libc::SYS_lchown]));
        if programs {
            rules.extend(all(&[libc::SYS_execve, libc::SYS_execveat]));
        }
        let when = |argument: u8, operator: SeccompCmpOp, value: u64| {
            let condition =
                SeccompCondition::new(argument, SeccompCmpArgLen::Qword, operator, value);
            let rule = condition.and_then(|condition| SeccompRule::new(vec![condition]));
            rule.map(|rule| vec![rule]).map_err(io::Error::other)
        };
        // Threads are allowed, processes are not.
        let thread = u64::from(libc::CLONE_THREAD.cast_unsigned());
        rules.push((libc::SYS_clone, when(0, SeccompCmpOp::MaskedEq(thread), 0)?));
        // A process may send signals only to itself: a program aborts in this way.
        let own = u64::from(std::process::id());
        rules.push((libc::SYS_tgkill, when(0, SeccompCmpOp::Ne, own)?));
        // Limits may be read but not set.
        rules.push((libc::SYS_prlimit64, when(2, SeccompCmpOp::Ne, 0)?));
        Ok(rules)
    }

    /// Calls that no template needs: connections, other processes, the system itself, and owners and
    /// attributes of files.
    const FORBIDDEN_CALLS: &[i64] = &[
        libc::SYS_socket,
        libc::SYS_socketpair,
        libc::SYS_connect,
        libc::SYS_bind,
        libc::SYS_listen,
        libc::SYS_ptrace,
        libc::SYS_process_vm_readv,
        libc::SYS_process_vm_writev,
        libc::SYS_process_madvise,
        libc::SYS_kill,
        libc::SYS_tkill,
        libc::SYS_rt_sigqueueinfo,
        libc::SYS_rt_tgsigqueueinfo,
        libc::SYS_pidfd_open,
        libc::SYS_pidfd_getfd,
        libc::SYS_pidfd_send_signal,
        libc::SYS_io_uring_enter,
        libc::SYS_io_uring_register,
        libc::SYS_shmget,
        libc::SYS_msgget,
        libc::SYS_semget,
        libc::SYS_mq_open,
        libc::SYS_mq_unlink,
        libc::SYS_setrlimit,
        libc::SYS_setpriority,
        libc::SYS_sched_setscheduler,
        libc::SYS_sched_setparam,
        libc::SYS_sched_setattr,
        libc::SYS_sched_setaffinity,
        libc::SYS_unshare,
        libc::SYS_setns,
        libc::SYS_mount,
        libc::SYS_umount2,
        libc::SYS_pivot_root,
        libc::SYS_chroot,
        libc::SYS_move_mount,
        libc::SYS_open_tree,
        libc::SYS_fsopen,
        libc::SYS_fsconfig,
        libc::SYS_fsmount,
        libc::SYS_fspick,
        libc::SYS_mount_setattr,
        libc::SYS_open_by_handle_at,
        libc::SYS_name_to_handle_at,
        libc::SYS_mknodat,
        libc::SYS_fchown,
        libc::SYS_fchownat,
        libc::SYS_setxattr,
        libc::SYS_lsetxattr,
        libc::SYS_fsetxattr,
        libc::SYS_removexattr,
        libc::SYS_lremovexattr,
        libc::SYS_fremovexattr,
        libc::SYS_fanotify_init,
        libc::SYS_quotactl,
        libc::SYS_acct,
        libc::SYS_swapon,
        libc::SYS_swapoff,
        libc::SYS_reboot,
        libc::SYS_kexec_load,
        libc::SYS_init_module,
        libc::SYS_finit_module,
        libc::SYS_delete_module,
        libc::SYS_bpf,
        libc::SYS_perf_event_open,
        libc::SYS_userfaultfd,
        libc::SYS_add_key,
        libc::SYS_request_key,
        libc::SYS_keyctl,
        libc::SYS_sethostname,
        libc::SYS_setdomainname,
        libc::SYS_settimeofday,
        libc::SYS_clock_settime,
        libc::SYS_clock_adjtime,
        libc::SYS_adjtimex,
        libc::SYS_syslog,
        libc::SYS_vhangup,
        libc::SYS_personality,
    ];
}
