/* Times of codels, for `cargo xtask bench runtime`. */
#include <fcntl.h>
#include <stdint.h>
#include <time.h>
#include <unistd.h>

/* The monotonic clock, in nanoseconds. */
static inline uint64_t
now(void)
{
  struct timespec time;

  clock_gettime(CLOCK_MONOTONIC, &time);
  return time.tv_sec * 1000000000ull + time.tv_nsec;
}

/* Appends a number to the file of this component. */
static inline void
note(uint64_t number)
{
  static int file = -1;

  if (file < 0) file = open(NUMBERS, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  (void)!write(file, &number, sizeof(number));
}
