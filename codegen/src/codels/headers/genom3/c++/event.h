// Events and exceptions, for editors and compilers that have no installation of GenoM3 at hand.
// Written by dotgen from the description of the C++ mapping.
#ifndef H_GENOM3_CXX_EVENT
#define H_GENOM3_CXX_EVENT

#include <cstdint>

#define genom_weak __attribute__((weak))
#define genom_extern_weak extern genom_weak

namespace genom {

// States and exceptions are told apart by address: one per name in the whole program.
typedef const char *event;

event genom_weak ok = nullptr;

const char genom_extern_weak fatal[] = "::genom::fatal";

struct exception {
  virtual ~exception() {}
  virtual const char *what() { return fatal; }
};

const char genom_extern_weak unkex_id[] = "::genom::unkex";
struct unkex_detail {
  char what[128];
};
struct unkex : public exception {
  unkex_detail detail;
  const char *what() { return unkex_id; }
};

const char genom_extern_weak syserr_id[] = "::genom::syserr";
struct syserr_detail {
  int32_t code;
};
struct syserr : public exception {
  syserr_detail detail;
  const char *what() { return syserr_id; }
};

}

#endif
