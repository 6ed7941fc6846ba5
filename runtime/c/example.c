/* Presses a finger into a beating heart for two seconds. Where beatlas is installed:
 *   cc example.c -o example $(pkg-config --cflags --libs beatlas)
 *   ./example heart.beatlas
 */
#include <stdio.h>

#include "runtime/c/beatlas.h"

int main(int argc, char** argv) {
  char message[256];
  if (argc != 2) {
    fprintf(stderr, "usage: example PACKAGE\n");
    return 2;
  }
  if (beatlas_c_version() != BEATLAS_C_VERSION) {
    fprintf(stderr, "libbeatlas is of another version than this program\n");
    return 1;
  }
  beatlas_options options = beatlas_default_options();
  options.radius_mm = 3; /* a sphere as large as a fingertip's pad */
  beatlas_session* session = beatlas_open(argv[1], "heart", &options, message, sizeof message);
  if (session == NULL) {
    fprintf(stderr, "%s\n", message);
    return 1;
  }
  const beatlas_info info = beatlas_get_info(session);
  printf("%.0f beats a minute, %d phases\n", 60 / info.rr_interval_s, info.phases);

  /* In an engine these ticks are the device's, 1000 a second, in its own thread. */
  double most_n = 0;
  beatlas_state state = {0};
  state.valid = 1;
  for (int tick = 0; tick < 2000; ++tick) {
    state.time_s = tick / 1000.0;
    for (int axis = 0; axis < 3; ++axis) state.position_mm[axis] = info.centre_mm[axis];
    state.position_mm[0] += 60 - 0.03 * tick; /* at 30 mm/s towards the centre */
    const beatlas_felt felt = beatlas_tick(session, &state);
    if (felt.status == BEATLAS_FAULT) {
      fprintf(stderr, "a fault at %.3f s\n", state.time_s);
      beatlas_close(session);
      return 1;
    }
    if (felt.force_n[0] > most_n) most_n = felt.force_n[0];
    if (tick % 500 == 499) {
      printf("%.1f s: %6.2f mm, %5.2f N\n", state.time_s, felt.distance_mm, felt.force_n[0]);
    }
  }
  const beatlas_seen seen = beatlas_look(session);
  printf("%llu ticks, at most %.2f N\n", (unsigned long long)seen.ticks, most_n);
  beatlas_close(session);
  return most_n > 0 ? 0 : 1;
}
