// Bounded sequences. Written by dotgen from the description of the C++ mapping.
#ifndef H_GENOM3_CXX_IDLSEQUENCE
#define H_GENOM3_CXX_IDLSEQUENCE

#include <algorithm>
#include <cstddef>
#include <stdexcept>

namespace genom {

// At most N elements, of which the first `n` count. An aggregate, as std::array is.
template <typename T, size_t N>
struct bounded_sequence {
  typedef T value_type;
  typedef T &reference;
  typedef const T &const_reference;
  typedef T *iterator;
  typedef const T *const_iterator;
  typedef size_t size_type;

  T e[N];
  size_type n;

  size_type size() const { return n; }
  size_type max_size() const { return N; }
  bool empty() const { return n == 0; }
  void clear() { n = 0; }

  void resize(size_type count, T value = T()) {
    if (count > N) throw std::out_of_range("genom::bounded_sequence::resize");
    if (count > n) std::fill(e + n, e + count, value);
    n = count;
  }

  iterator begin() { return e; }
  iterator end() { return e + n; }
  const_iterator begin() const { return e; }
  const_iterator end() const { return e + n; }

  reference operator[](size_type at) { return e[at]; }
  const_reference operator[](size_type at) const { return e[at]; }
  reference at(size_type i) {
    if (i >= n) throw std::out_of_range("genom::bounded_sequence::at");
    return e[i];
  }
  const_reference at(size_type i) const {
    if (i >= n) throw std::out_of_range("genom::bounded_sequence::at");
    return e[i];
  }
  reference front() { return e[0]; }
  const_reference front() const { return e[0]; }
  reference back() { return e[n > 0 ? n - 1 : 0]; }
  const_reference back() const { return e[n > 0 ? n - 1 : 0]; }
  T *data() { return e; }
  const T *data() const { return e; }
};

template <typename T, size_t N>
inline bool operator==(const bounded_sequence<T, N> &a, const bounded_sequence<T, N> &b) {
  return a.n == b.n && std::equal(a.begin(), a.end(), b.begin());
}

template <typename T, size_t N>
inline bool operator!=(const bounded_sequence<T, N> &a, const bounded_sequence<T, N> &b) {
  return !(a == b);
}

}

#endif
