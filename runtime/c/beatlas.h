/* Feel a beating-heart atlas from any engine: the C interface of the beatlas runtime.
 *
 * Lengths in mm and positions in the workspace's frame of the package (runtime/base/geometry.h),
 * forces in N on the user, times in s. Errors: a function that can fail returns 0 (or NULL) and
 * writes one sentence into `message`, always ended by a zero; `message` may be NULL.
 *
 * Threads: `beatlas_tick` is called by one thread, the servo's; it never allocates, locks, waits,
 * logs or reads. All else may be called by one other thread at the same time.
 */
#ifndef BEATLAS_C_H
#define BEATLAS_C_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define BEATLAS_API __attribute__((visibility("default")))
#else
#define BEATLAS_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Rises when a struct or the meaning of a function changes. */
#define BEATLAS_C_VERSION 5
/* The version that the library was built with. */
BEATLAS_API int beatlas_c_version(void);

typedef struct beatlas_session beatlas_session;

typedef enum {
  BEATLAS_PROXY = 0,     /* a point, sphere or capsule the moving surface carries along */
  BEATLAS_TWO_STEP = 1,  /* Nakao et al., MEDINFO 2001, continuous in time */
  BEATLAS_PUBLISHED = 2, /* the same as published: linear between the forces at stored frames */
  BEATLAS_FINGERTIP = 3  /* an area of points on the side of -z of the tool */
} beatlas_model;

typedef struct {
  beatlas_model model;
  double stiffness_n_per_m; /* 1..5000; 0: the package's */
  /* proxy: 0, a point, to the largest distance at which the package knows directions: 4.5 mm as
   * built by default, with `inside` 13.5; fingertip: 0.1..50, 0 is 8 mm */
  double radius_mm;
  double damping_n_s_per_m;  /* proxy: 0..100 */
  double friction_static;    /* proxy: 0..1, while the tool sticks */
  double friction_dynamic;   /* proxy: 0..static, while it slides */
  size_t points;             /* fingertip: 1..10000 */
  double heart_rate_per_min; /* 10..300; 0: the package's */
  /* 0.05..40: largest force. Besides, the force stays that of 15 mm of depth for what is deeper:
   * 2.25 N at 150 N/m. No option changes that. */
  double peak_n;
  double slew_n_per_s;   /* 1..5000: largest change of force, but to zero on a fault */
  double max_gap_s;      /* 0.001..1: a longer gap between ticks is a fault */
  double start_ramp_s;   /* 0..10: rise at the start and after a fault */
  double half_length_mm; /* proxy: 0..100 of a capsule's axis, the tool's z; 0: none */
  int inside; /* proxy, fingertip: not 0: in the structure, whose wall is felt from within */
} beatlas_options;

/* What stands in for options that are not given. */
BEATLAS_API beatlas_options beatlas_default_options(void);

typedef struct {
  double rr_interval_s;
  int phases;
  double stiffness_n_per_m;
  double centre_mm[3];           /* of the structure over the cycle */
  double workspace_from_lps[16]; /* row-major; rigid */
} beatlas_info;

/* Opens a package and loads `structure` ("heart", "lv_blood", ...; NULL: "heart") to be touched.
 * options may be NULL. */
BEATLAS_API beatlas_session* beatlas_open(const char* package, const char* structure,
                                          const beatlas_options* options, char* message,
                                          size_t message_size);
/* Another tool on the heart of `session`, which is not read again: each tool is ticked by its own
 * thread, and its heart begins to beat with its first tick, so begin all at one moment. A swap is
 * of one session alone. To be closed as well, in any order. */
BEATLAS_API beatlas_session* beatlas_open_beside(const beatlas_session* session,
                                                 const beatlas_options* options, char* message,
                                                 size_t message_size);
/* After the last tick. NULL is passed over. */
BEATLAS_API void beatlas_close(beatlas_session* session);

BEATLAS_API beatlas_info beatlas_get_info(const beatlas_session* session);

typedef struct {
  /* Of the device's clock; rises. One tick may repeat the time of the one before, and its force;
   * from the next on a time that does not go on is a fault. */
  double time_s;
  double position_mm[3]; /* the tool's centre */
  double orientation[4]; /* workspace_from_tool: x y z w; all 0: none */
  int valid;             /* 0: the state cannot be trusted; the force is zero */
} beatlas_state;

typedef enum { BEATLAS_OK = 0, BEATLAS_LIMITED = 1, BEATLAS_FAULT = 2 } beatlas_status;

typedef struct {
  beatlas_status status; /* limited: made smaller by the safety stage; fault: zero */
  double force_n[3];     /* may be sent whatever the status is */
  /* fingertip, capsule: scaled as the safety stage scaled the force, and changing by at most
   * slew_n_per_s times the way from the tool's centre to its farthest point */
  double torque_n_mm[3];
  double distance_mm; /* of the tool from the surface, negative inside */
  double proxy_mm[3]; /* where the tool's centre would be, had it not gone in */
  double normal[3];   /* outward */
  double surface_velocity_mm_s;
  int touching;
} beatlas_felt;

/* Servo's thread. NULL for session gives a fault. */
BEATLAS_API beatlas_felt beatlas_tick(beatlas_session* session, const beatlas_state* state);

/* Another thread: taken up at the next tick. Phase and rate of the heart never jump. */
BEATLAS_API void beatlas_set_heart_rate(beatlas_session* session, double beats_per_min);
BEATLAS_API void beatlas_set_paused(beatlas_session* session, int paused);
/* 0..1, a share of the cycle and no number of a stored phase: beat on to it and stay there; below
 * 0: let go. 1 if it was taken; 0, and all stays as it was, beyond 1 or where it is no number. */
BEATLAS_API int beatlas_hold_phase(beatlas_session* session, double phase);
BEATLAS_API void beatlas_stop(beatlas_session* session);    /* zero force until restart */
BEATLAS_API void beatlas_restart(beatlas_session* session); /* with the start ramp */
/* Another package under the running servo: one tick of zero force, then the ramp. Info and queries
 * are the new package's at once. What was replaced is freed by the next swap or by close. */
BEATLAS_API int beatlas_swap(beatlas_session* session, const char* package, char* message,
                             size_t message_size);

typedef struct {
  uint64_t ticks;
  double time_s;
  double phase; /* of the cycle, 0..1 */
  double heart_rate_per_min;
  double position_mm[3];
  double proxy_mm[3];
  double force_n[3];
  double distance_mm;
  beatlas_status status;
  int touching;
} beatlas_seen;

/* Another thread, for graphics: the newest tick as a whole. */
BEATLAS_API beatlas_seen beatlas_look(const beatlas_session* session);

typedef struct {
  double pressure_kpa[64]; /* mean on each of 8 x 8 taxels, row after row */
  double pitch_mm;         /* from taxel to taxel: a quarter of the tool's radius */
  double area_mm2;         /* of contact */
  double peak_kpa;
  double centre_mm[3]; /* of the map, on the plane of contact */
  double right[3];     /* columns run this way, rows along `up`; all 0 where nothing is touched */
  double up[3];
} beatlas_taxel_map;

/* Another thread, for tactile displays: how the pressure of the newest tick is spread under the
 * ball of a proxy that has a radius, from outside, or under a fingertip. `right`: which way the
 * columns run; NULL: the workspace's x. Fails for other tools. */
BEATLAS_API int beatlas_taxels(beatlas_session* session, const double* right,
                               beatlas_taxel_map* map, char* message, size_t message_size);

/* Another thread: signed distance [mm] and outward unit normal of `count` points (x y z each) at
 * `phase` of the cycle, 0..1, beyond it as one or more cycles on; either output may be NULL. Beyond
 * the band the distance is clamped. */
BEATLAS_API void beatlas_query(const beatlas_session* session, const double* points_mm,
                               size_t count, double phase, double* distances_mm, double* normals);

/* Another thread: how near the true surface lies to the package's with a probability of 90 %, as a
 * half width [mm], at `count` points (x y z each) on or near the surface at `phase` of the cycle.
 * In force that is the width times the stiffness. Fails where the package does not tell it, and
 * where a point or the phase is no number; then nothing is written. */
BEATLAS_API int beatlas_known_within(const beatlas_session* session, const double* points_mm,
                                     size_t count, double phase, double* half_widths_mm,
                                     char* message, size_t message_size);

#ifdef __cplusplus
}
#endif

#endif
