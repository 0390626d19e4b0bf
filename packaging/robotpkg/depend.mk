# robotpkg depend.mk for:	architecture/dotgen
#

DEPEND_DEPTH:=		${DEPEND_DEPTH}+
DOTGEN_DEPEND_MK:=	${DOTGEN_DEPEND_MK}+

ifeq (+,$(DEPEND_DEPTH))
DEPEND_PKG+=		dotgen
endif

ifeq (+,$(DOTGEN_DEPEND_MK)) # ---------------------------------------------

DEPEND_USE+=		dotgen
PREFER.dotgen?=		robotpkg

SYSTEM_SEARCH.dotgen=\
  'bin/dotgen:s/[^0-9.]//gp:% --version'

DEPEND_ABI.dotgen?=	dotgen>=0.1.0
DEPEND_DIR.dotgen?=	../../architecture/dotgen

export DOTGEN=	${PREFIX.dotgen}/bin/dotgen

endif # DOTGEN_DEPEND_MK ------------------------------------------------------

DEPEND_DEPTH:=		${DEPEND_DEPTH:+=}
