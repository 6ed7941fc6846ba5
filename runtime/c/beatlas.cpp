#include "runtime/c/beatlas.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "runtime/atlas/atlas.h"
#include "runtime/atlas/surface_band.h"
#include "runtime/base/error.h"
#include "runtime/haptics/cavity_field.h"
#include "runtime/haptics/proxy.h"
#include "runtime/haptics/servo.h"
#include "runtime/haptics/shell.h"
#include "runtime/haptics/taxels.h"

namespace {

using beatlas::Vec3;
namespace haptics = beatlas::haptics;
namespace field = beatlas::field;

struct Opened {
  std::shared_ptr<const field::FieldQuery> field;
  beatlas::atlas::Manifest manifest;
};

Opened open_package(const char* package, beatlas::Structure structure) {
  if (package == nullptr) beatlas::throw_invalid("no package is named");
  const beatlas::atlas::Atlas atlas =
      beatlas::atlas::Atlas::open(package, {.fields = {structure}, .surfaces = {}});
  return {std::make_shared<const field::FieldQuery>(atlas.field(structure),
                                                    atlas.manifest().rr_interval_s),
          atlas.manifest()};
}

// A caller in C may have put any number there, which C++ may not read as the enumeration.
int model_of(const beatlas_options& options) {
  int out = 0;
  static_assert(sizeof(out) == sizeof(options.model));
  std::memcpy(&out, &options.model, sizeof(out));
  return out;
}

std::shared_ptr<const haptics::ContactField> body_of(const Opened& opened,
                                                     const beatlas_options& options) {
  if (options.inside != 0) return haptics::cavity_of(opened.field);
  return std::make_shared<const haptics::AtlasField>(opened.field);
}

double radius_mm(const beatlas_options& options) {
  constexpr double kFingertipMm = 8;
  const bool untold = model_of(options) == BEATLAS_FINGERTIP && options.radius_mm == 0;
  return untold ? kFingertipMm : options.radius_mm;
}

std::unique_ptr<haptics::ShellModel> fingertip_of(const Opened& opened,
                                                  const beatlas_options& options) {
  return std::make_unique<haptics::ShellModel>(
      body_of(opened, options), haptics::fingertip(radius_mm(options), options.points),
      haptics::ShellOptions{});
}

haptics::Scene make_scene(const Opened& opened, const beatlas_options& options) {
  haptics::Scene scene;
  scene.period_s = opened.manifest.rr_interval_s;
  const double stiffness = options.stiffness_n_per_m == 0 ? opened.manifest.stiffness_n_per_m
                                                          : options.stiffness_n_per_m;
  const int wanted = model_of(options);
  if (options.inside != 0 && (wanted == BEATLAS_TWO_STEP || wanted == BEATLAS_PUBLISHED)) {
    beatlas::throw_invalid("a cavity is felt from within by the proxy or a fingertip alone");
  }
  switch (wanted) {
    case BEATLAS_PROXY: {
      haptics::ProxyOptions model;
      model.stiffness_n_per_m = stiffness;
      model.radius_mm = options.radius_mm;
      model.half_length_mm = options.half_length_mm;
      model.damping_n_s_per_m = options.damping_n_s_per_m;
      model.friction_static = options.friction_static;
      model.friction_dynamic = options.friction_dynamic;
      scene.model = std::make_unique<haptics::ProxyModel>(body_of(opened, options), model);
      break;
    }
    case BEATLAS_TWO_STEP:
    case BEATLAS_PUBLISHED: {
      haptics::TwoStepOptions model;
      model.stiffness_n_per_m = stiffness;
      if (wanted == BEATLAS_PUBLISHED) model.time_mode = haptics::TimeMode::Published;
      scene.model = std::make_unique<haptics::TwoStepModel>(opened.field, model);
      break;
    }
    case BEATLAS_FINGERTIP:
      scene.model = fingertip_of(opened, options);
      break;
    default:
      beatlas::throw_invalid("there is no such force model");
  }
  return scene;
}

haptics::ServoOptions servo_options(const beatlas_options& options) {
  haptics::ServoOptions out;
  out.safety.peak_n = options.peak_n;
  out.safety.slew_n_per_s = options.slew_n_per_s;
  out.safety.max_gap_s = options.max_gap_s;
  out.safety.start_ramp_s = options.start_ramp_s;
  if (options.heart_rate_per_min != 0) out.heart.rate_per_min = options.heart_rate_per_min;
  return out;
}

void copy(const Vec3& from, double* to) { std::copy_n(from.data(), 3, to); }

void tell(const char* what, char* message, size_t size) {
  if (message == nullptr || size == 0) return;
  const size_t length = std::min(std::strlen(what), size - 1);
  std::memcpy(message, what, length);
  message[length] = '\0';
}

// No exception crosses into C.
template <class Call>
bool guarded(Call call, char* message, size_t size) {
  tell("", message, size);
  try {
    call();
    return true;
  } catch (const std::bad_alloc&) {
    tell("there is not enough memory", message, size);
  } catch (const std::exception& error) {
    tell(error.what(), message, size);
  } catch (...) {
    tell("something went wrong that has no name", message, size);
  }
  return false;
}

}  // namespace

struct beatlas_session {
  beatlas::Structure structure;
  beatlas_options options;
  Opened opened;
  haptics::Servo servo;
  haptics::TorqueStage torque;
  std::unique_ptr<haptics::Taxels> taxels;  ///< of `opened`, made when they are first asked for
  std::unique_ptr<haptics::ShellModel> fingertip;  ///< for taxels: likewise, beside the servo's own

  beatlas_session(beatlas::Structure which, const beatlas_options& how, Opened package)
      : structure(which),
        options(how),
        opened(std::move(package)),
        servo(make_scene(opened, options), servo_options(options)),
        torque(options.slew_n_per_s, radius_mm(options) + options.half_length_mm) {}
};

namespace {

// What a tool needs for its taxels is made when they are first asked for.
haptics::TaxelMap newest_taxels(beatlas_session& session, const Vec3& right) {
  const beatlas_options& options = session.options;
  const Opened& opened = session.opened;
  const int model = model_of(options);
  const bool ball = model == BEATLAS_PROXY && options.half_length_mm == 0 && options.inside == 0;
  if (!ball && model != BEATLAS_FINGERTIP) {
    beatlas::throw_invalid(
        "only a ball and a fingertip have taxels; open the session with BEATLAS_PROXY from outside "
        "and without half_length_mm, or with BEATLAS_FINGERTIP");
  }
  if (ball && !session.taxels) {
    session.taxels = std::make_unique<haptics::Taxels>(
        body_of(opened, options), haptics::TaxelOptions{.radius_mm = options.radius_mm});
  }
  if (!ball && !session.fingertip) session.fingertip = fingertip_of(opened, options);
  const haptics::Published seen = session.servo.published();
  const double t = seen.phase * opened.field->rr_interval_s();
  return ball ? session.taxels->under(haptics::ball_contact(seen, right), t)
              : haptics::taxels_of(*session.fingertip, seen, t, right);
}

}  // namespace

extern "C" {

int beatlas_c_version(void) { return BEATLAS_C_VERSION; }

beatlas_options beatlas_default_options(void) {
  const haptics::SafetyOptions safety;
  beatlas_options out{};
  out.model = BEATLAS_PROXY;
  out.points = 2000;
  out.peak_n = safety.peak_n;
  out.slew_n_per_s = safety.slew_n_per_s;
  out.max_gap_s = safety.max_gap_s;
  out.start_ramp_s = safety.start_ramp_s;
  return out;
}

beatlas_session* beatlas_open(const char* package, const char* structure,
                              const beatlas_options* options, char* message, size_t message_size) {
  std::unique_ptr<beatlas_session> session;
  (void)guarded(
      [&] {
        const char* const name = structure == nullptr ? "heart" : structure;
        const auto known = beatlas::structure_from_name(name);
        if (!known) beatlas::throw_invalid(std::string("there is no structure ") + name);
        session = std::make_unique<beatlas_session>(
            *known, options == nullptr ? beatlas_default_options() : *options,
            open_package(package, *known));
      },
      message, message_size);
  return session.release();
}

beatlas_session* beatlas_open_beside(const beatlas_session* session, const beatlas_options* options,
                                     char* message, size_t message_size) {
  std::unique_ptr<beatlas_session> beside;
  (void)guarded(
      [&] {
        if (session == nullptr) beatlas::throw_invalid("there is no session to open a tool beside");
        beside = std::make_unique<beatlas_session>(
            session->structure, options == nullptr ? beatlas_default_options() : *options,
            session->opened);
      },
      message, message_size);
  return beside.release();
}

void beatlas_close(beatlas_session* session) { delete session; }

beatlas_info beatlas_get_info(const beatlas_session* session) {
  beatlas_info out{};
  if (session == nullptr) return out;
  const beatlas::atlas::Manifest& manifest = session->opened.manifest;
  out.rr_interval_s = manifest.rr_interval_s;
  out.phases = session->opened.field->phases();
  out.stiffness_n_per_m = manifest.stiffness_n_per_m;
  copy(session->opened.field->centre_mm(), out.centre_mm);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      out.workspace_from_lps[4 * row + column] = manifest.workspace_from_lps.matrix()(row, column);
    }
  }
  return out;
}

beatlas_felt beatlas_tick(beatlas_session* session, const beatlas_state* state) {
  beatlas_felt out{};
  out.status = BEATLAS_FAULT;
  if (session == nullptr) return out;
  haptics::ServoState in;
  in.valid = state != nullptr && state->valid != 0;
  if (state != nullptr) {
    const double* const q = state->orientation;
    in.time_s = state->time_s;
    in.position_mm = Vec3(state->position_mm[0], state->position_mm[1], state->position_mm[2]);
    const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
    if (turn.squaredNorm() != 0) in.orientation = turn;
  }
  const haptics::Tick tick = session->servo.tick(in);
  out.status = static_cast<beatlas_status>(tick.status);
  copy(tick.force_n, out.force_n);
  copy(session->torque.apply(tick.contact.torque_n_mm, tick.contact.force_n,
                             {tick.force_n, tick.status}, in.time_s),
       out.torque_n_mm);
  out.distance_mm = tick.contact.distance_mm;
  copy(tick.contact.proxy_mm, out.proxy_mm);
  copy(tick.contact.normal, out.normal);
  out.surface_velocity_mm_s = tick.contact.surface_velocity_mm_s;
  out.touching = tick.contact.touching ? 1 : 0;
  return out;
}

void beatlas_set_heart_rate(beatlas_session* session, double beats_per_min) {
  if (session != nullptr) session->servo.set_rate_hz(beats_per_min / 60);
}
void beatlas_set_paused(beatlas_session* session, int paused) {
  if (session != nullptr) session->servo.set_paused(paused != 0);
}
int beatlas_hold_phase(beatlas_session* session, double phase) {
  // The form turns away what is no number, too.
  if (session == nullptr || !(phase <= 1)) return 0;
  session->servo.hold_phase(phase);
  return 1;
}
void beatlas_stop(beatlas_session* session) {
  if (session != nullptr) session->servo.stop();
}
void beatlas_restart(beatlas_session* session) {
  if (session != nullptr) session->servo.restart();
}

int beatlas_swap(beatlas_session* session, const char* package, char* message,
                 size_t message_size) {
  const bool done = guarded(
      [&] {
        if (session == nullptr) beatlas::throw_invalid("there is no session to swap a package in");
        Opened opened = open_package(package, session->structure);
        session->servo.offer(make_scene(opened, session->options));
        session->opened = std::move(opened);
        session->taxels.reset();
        session->fingertip.reset();
      },
      message, message_size);
  return done ? 1 : 0;
}

beatlas_seen beatlas_look(const beatlas_session* session) {
  beatlas_seen out{};
  out.status = BEATLAS_FAULT;
  if (session == nullptr) return out;
  const haptics::Published seen = session->servo.published();
  out.ticks = seen.ticks;
  out.time_s = seen.time_s;
  out.phase = seen.phase;
  out.heart_rate_per_min = 60 * seen.rate_hz;
  std::copy(seen.position_mm.begin(), seen.position_mm.end(), out.position_mm);
  std::copy(seen.proxy_mm.begin(), seen.proxy_mm.end(), out.proxy_mm);
  std::copy(seen.force_n.begin(), seen.force_n.end(), out.force_n);
  out.distance_mm = seen.distance_mm;
  out.status = static_cast<beatlas_status>(seen.status);
  out.touching = seen.touching ? 1 : 0;
  return out;
}

int beatlas_taxels(beatlas_session* session, const double* right, beatlas_taxel_map* map,
                   char* message, size_t message_size) {
  const bool done = guarded(
      [&] {
        if (session == nullptr || map == nullptr) {
          beatlas::throw_invalid("taxels need a session, and a map to write into");
        }
        const haptics::TaxelMap found =
            newest_taxels(*session, right == nullptr ? Vec3::UnitX() : Vec3(right));
        std::copy(found.pressure_kpa.begin(), found.pressure_kpa.end(), map->pressure_kpa);
        map->pitch_mm = found.pitch_mm;
        map->area_mm2 = found.area_mm2;
        map->peak_kpa = found.peak_kpa;
        copy(found.centre_mm, map->centre_mm);
        copy(found.right, map->right);
        copy(found.up, map->up);
      },
      message, message_size);
  return done ? 1 : 0;
}

void beatlas_query(const beatlas_session* session, const double* points_mm, size_t count,
                   double phase, double* distances_mm, double* normals) {
  if (session == nullptr || points_mm == nullptr) return;
  const field::FieldQuery& body = *session->opened.field;
  const double t = phase * body.rr_interval_s();
  for (size_t n = 0; n < count; ++n) {
    const Vec3 x(points_mm[3 * n], points_mm[3 * n + 1], points_mm[3 * n + 2]);
    const field::FieldSample sample = body.sample(x, t);
    if (distances_mm != nullptr) distances_mm[n] = sample.distance_mm;
    if (normals != nullptr) copy(body.normal(sample, x), normals + 3 * n);
  }
}

int beatlas_known_within(const beatlas_session* session, const double* points_mm, size_t count,
                         double phase, double* half_widths_mm, char* message, size_t message_size) {
  const bool done = guarded(
      [&] {
        if (session == nullptr || points_mm == nullptr || half_widths_mm == nullptr) {
          beatlas::throw_invalid("it takes a session, points, and widths to write into");
        }
        const auto band = beatlas::atlas::band_query(session->opened.manifest, session->structure);
        if (!band) {
          beatlas::throw_invalid("the package does not tell how well the surface of " +
                                 std::string(beatlas::structure_name(session->structure)) +
                                 " is known");
        }
        const field::FieldQuery& body = *session->opened.field;
        if (!std::isfinite(phase)) beatlas::throw_invalid("the phase must be a number");
        for (size_t n = 0; n < 3 * count; ++n) {
          if (std::isfinite(points_mm[n])) continue;
          beatlas::throw_invalid("point " + std::to_string(n / 3) +
                                 ", counted from 0, must be three numbers in mm");
        }
        for (size_t n = 0; n < count; ++n) {
          const Vec3 x(points_mm[3 * n], points_mm[3 * n + 1], points_mm[3 * n + 2]);
          const Vec3 normal = body.normal(body.sample(x, phase * body.rr_interval_s()), x);
          half_widths_mm[n] = band->half_width_mm(x, normal, phase);
        }
      },
      message, message_size);
  return done ? 1 : 0;
}

}  // extern "C"
