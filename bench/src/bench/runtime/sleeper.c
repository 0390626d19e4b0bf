/* Wakes up every millisecond with the real-time priority of a codel, and writes by how much it is late:
   sleeper SECONDS FILE */
#define _GNU_SOURCE
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <time.h>

int
main(int count, char **words)
{
  struct sched_param priority = { .sched_priority = 48 };
  struct timespec due, time;
  long ticks = count == 3 ? atof(words[1]) * 1000 : 0;
  uint64_t *late = calloc(ticks + 1, sizeof(*late));
  FILE *file = count == 3 ? fopen(words[2], "w") : NULL;

  if (late == NULL || file == NULL) return 2;
  if (mlockall(MCL_CURRENT | MCL_FUTURE) || sched_setscheduler(0, SCHED_FIFO, &priority))
    fprintf(stderr, "no real-time priority\n");
  clock_gettime(CLOCK_MONOTONIC, &due);
  for (long i = 0; i < ticks; i++) {
    due.tv_nsec += 1000000;
    if (due.tv_nsec >= 1000000000) due.tv_sec++, due.tv_nsec -= 1000000000;
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, NULL);
    clock_gettime(CLOCK_MONOTONIC, &time);
    late[i] = (time.tv_sec - due.tv_sec) * 1000000000ll + time.tv_nsec - due.tv_nsec;
  }
  return fwrite(late, sizeof(*late), ticks, file) == (size_t)ticks && !fclose(file) ? 0 : 2;
}
