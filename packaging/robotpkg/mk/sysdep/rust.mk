# robotpkg sysdep/rust.mk
#

DEPEND_DEPTH:=		${DEPEND_DEPTH}+
RUST_DEPEND_MK:=	${RUST_DEPEND_MK}+

ifeq (+,$(DEPEND_DEPTH))
DEPEND_PKG+=		rust
endif

ifeq (+,$(RUST_DEPEND_MK)) # -----------------------------------------------

PREFER.rust?=		system

DEPEND_USE+=		rust
DEPEND_ABI.rust?=	rust>=1.63
DEPEND_METHOD.rust+=	build
SYSTEM_SEARCH.rust=\
  'bin/cargo:1{s/^[^0-9]*//;s/[^0-9.].*$$//;p;}:% --version'	\
  'bin/rustc:1{s/^[^0-9]*//;s/[^0-9.].*$$//;p;}:% --version'

SYSTEM_PKG.Debian.rust=	cargo
SYSTEM_PKG.Fedora.rust=	cargo

export CARGO=		${PREFIX.rust}/bin/cargo

# HOME is in WRKDIR during a build. The toolchains of rustup are in the user's.
RUSTUP_HOME?=		${HOME}/.rustup
export RUSTUP_HOME

endif # RUST_DEPEND_MK -----------------------------------------------------

DEPEND_DEPTH:=		${DEPEND_DEPTH:+=}
