// Optional values. Written by dotgen from the description of the C++ mapping.
#ifndef H_GENOM3_CXX_IDLOPTIONAL
#define H_GENOM3_CXX_IDLOPTIONAL

namespace genom {

template <typename T>
struct optional {
  typedef T value_type;

  bool _present;
  value_type _value;
};

}

#endif
