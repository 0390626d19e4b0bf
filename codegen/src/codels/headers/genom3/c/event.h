/* Events, for editors and compilers that have no installation of GenoM3 at hand. Written by dotgen
 * from the description of the C mapping; the headers of GenoM3 take their place in real builds. */
#ifndef H_GENOM3_C_EVENT
#define H_GENOM3_C_EVENT

/* States and exceptions are told apart by address: one per name in the whole program. */
typedef const char *genom_event;

#define genom_weak __attribute__((weak, visibility("default")))

#ifdef __cplusplus
/* A constant is local to its file unless it says otherwise. */
#define genom_extern_weak extern genom_weak
#else
#define genom_extern_weak genom_weak
#endif

#endif
