/*
 * The serial line, in a simulation: what is sent waits here until codel
 * mk_main_publish copies it to port `line_command`.
 */
#ifndef MIKROKOPTER_LINE_H
#define MIKROKOPTER_LINE_H

enum { line_rotors = 4 };

static const double line_idle = 16.;  /* Hz, of a propeller that has started */

struct mikrokopter_line_s {
  uint32_t baud;                     /* bits per second; 0: reading does not wait */
  _Atomic double sent[line_rotors];  /* Hz; atomic because the control task sends, too */
};

/* As with a file descriptor, who may read the line may send: the contents are not const. */
static inline void
line_send(const mikrokopter_line_s *line, const quad_rotors_velocities *wanted)
{
  mikrokopter_line_s *to = (mikrokopter_line_s *)line;
  for (int i = 0; to && i < line_rotors; i++)
    to->sent[i] = wanted->w._length > (uint32_t)i ? wanted->w._buffer[i] : 0.;
}

static inline void
line_send_all(const mikrokopter_line_s *line, double speed)
{
  mikrokopter_line_s *to = (mikrokopter_line_s *)line;
  for (int i = 0; to && i < line_rotors; i++) to->sent[i] = speed;
}

#endif /* MIKROKOPTER_LINE_H */
