#include "runtime/app/trainee.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/exercise/random.h"

namespace beatlas::app {
namespace {

constexpr double kHandTickS = 1e-3;
constexpr double kPressDepthMm = 4;  ///< some 1 N on a healthy wall
constexpr double kClearMm = 12;      ///< outside of a place, from where it is approached
constexpr double kTravelMm = 15;     ///< outside of the whole heart, on the way to the next place

/// What a finger felt at a place [N].
struct FeltPlace {
  std::uint32_t vertex = 0;
  double diastole_n = 0;
  double systole_n = 0;
};

double gaussian(exercise::Random& random) {
  const double radius = std::sqrt(-2 * std::log(1 - random.unit()));
  return radius * std::cos(2 * std::numbers::pi * random.unit());
}

/// Touchable vertices, each as far as can be from those before it, until they lie `spacing_mm`
/// apart.
std::vector<std::uint32_t> spread_places(const exercise::Ground& ground, double spacing_mm,
                                         std::size_t first) {
  std::vector<std::uint32_t> all;
  for (std::uint32_t v = 0; v < ground.touchable.size(); ++v) {
    if (ground.touchable[v]) all.push_back(v);
  }
  std::vector<std::uint32_t> out;
  std::vector<double> away(all.size(), std::numeric_limits<double>::infinity());
  std::size_t next = first % all.size();
  while (away[next] >= spacing_mm) {
    out.push_back(all[next]);
    for (std::size_t n = 0; n < all.size(); ++n) {
      away[n] = std::min(away[n], (ground.wall.mm(all[n]) - ground.wall.mm(all[next])).norm());
    }
    next = static_cast<std::size_t>(std::max_element(away.begin(), away.end()) - away.begin());
  }
  return out;
}

/// Each place after the one that is nearest to it: less way.
std::vector<std::uint32_t> along_a_way(std::vector<std::uint32_t> places,
                                       const palpation::LvWall& wall) {
  for (std::size_t n = 1; n + 1 < places.size(); ++n) {
    const Vec3 here = wall.mm(places[n - 1]);
    const auto begin = places.begin() + static_cast<std::ptrdiff_t>(n);
    std::iter_swap(begin, std::min_element(begin, places.end(), [&](auto a, auto b) {
                     return (wall.mm(a) - here).norm() < (wall.mm(b) - here).norm();
                   }));
  }
  return places;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Skill skill_from_name(const std::string& name) {
  if (name == "skilled") return {};
  if (name == "unskilled") {
    return {.weber = 0.3,
            .most_places = 6,
            .second_looks = 0,
            .knows_normal = false,
            .knows_names = false};
  }
  throw Error(ErrorCode::Usage,
              "there is no trainee " + name + "; there are skilled and unskilled");
}

/// Moves a finger tick by tick.
class Trainee::Hand {
 public:
  /// @param finger_mm radius of the fingertip, whose middle is moved
  Hand(const ExerciseGround& atlas, double finger_mm, double heart_rate_per_min,
       const device::ServoFn& servo, device::Pace pace, std::stop_token stop)
      : atlas_(atlas),
        finger_mm_(finger_mm),
        field_(*atlas.field()),
        servo_(servo),
        stop_(std::move(stop)),
        pacer_(pace, 1 / kHandTickS),
        speed_(heart_rate_per_min > 0 ? heart_rate_per_min / 60 * field_.rr_interval_s() : 1) {
    for (const std::optional<Vec3>& place : atlas.over()) {
      if (place) {
        farthest_mm_ = std::max(farthest_mm_, (*place - field_.centre_mm()).norm());
      }
    }
    farthest_mm_ += finger_mm;
    at_mm_ = field_.centre_mm() + (farthest_mm_ + kTravelMm) * Vec3::UnitX();
  }

  [[nodiscard]] bool stopped() const { return stop_.stop_requested(); }
  [[nodiscard]] device::RunReport report() const { return pacer_.report(); }

  /// Goes there outside of the heart, presses over a beat and a half and comes back out.
  /// @param button pressed with the finger in; none: -1
  FeltPlace press(std::uint32_t vertex, int button) {
    const Vec3 place = *atlas_.over()[vertex];
    const Vec3 outward = field_.normal(field_.sample(place, atlas_.end_diastole_s()), place);
    travel(place + (finger_mm_ + kClearMm) * outward);
    above_mm_ = 0;
    FeltPlace out{.vertex = vertex};
    const double beat_s = field_.rr_interval_s() / speed_;
    const auto goes_in = static_cast<int>(0.25 * beat_s / kHandTickS);
    const auto settles = static_cast<int>(0.5 * beat_s / kHandTickS);
    const auto held = static_cast<int>(1.5 * beat_s / kHandTickS);
    double least = std::numeric_limits<double>::infinity();
    double nearest_systole = std::numeric_limits<double>::infinity();
    for (int n = 0; n < goes_in + held + goes_in && !stopped(); ++n) {
      const double in = std::min({1.0, static_cast<double>(n) / goes_in,
                                  static_cast<double>(2 * goes_in + held - n) / goes_in});
      follow_surface(place, outward);
      const bool presses = button >= 0 && n > goes_in + settles && n < goes_in + held;
      const double force_n = tick(
          place + (above_mm_ + finger_mm_ + kClearMm - in * (kClearMm + kPressDepthMm)) * outward,
          presses ? 1U << static_cast<unsigned>(button) : 0U);
      // Of a whole beat, once the wall has forgotten most of how it was touched.
      if (n < goes_in + settles || n >= goes_in + held) continue;
      note(away_from(atlas_.end_diastole_s()), force_n, least, out.diastole_n);
      note(away_from(end_systole_s()), force_n, nearest_systole, out.systole_n);
    }
    return out;
  }

 private:
  [[nodiscard]] double end_systole_s() const {
    return field_.rr_interval_s() * atlas_.manifest().end_systole / field_.phases();
  }
  [[nodiscard]] double field_time_s() const { return speed_ * time_s_; }
  /// [s] of the field's cycle
  [[nodiscard]] double away_from(double moment_s) const {
    const double cycle = field_.rr_interval_s();
    const double away = std::remainder(field_time_s() - moment_s, cycle);
    return std::abs(away);
  }
  static void note(double away_s, double force_n, double& least_s, double& noted_n) {
    if (away_s >= least_s) return;
    least_s = away_s;
    noted_n = force_n;
  }
  /// Where the moving surface lies along `outward`, above the place: the distance is the way to go
  /// where that line stands upright on it, and little changes from tick to tick.
  void follow_surface(const Vec3& place, const Vec3& outward) {
    for (int n = 0; n < 3; ++n) {
      above_mm_ -= field_.sample(place + above_mm_ * outward, field_time_s()).distance_mm;
    }
  }
  void travel(const Vec3& to) {
    constexpr int kLegTicks = 250;
    constexpr double kNextMm = 20;  // straight on, clear of a wall that is bent as a heart's is
    const Vec3 centre = field_.centre_mm();
    const double around = farthest_mm_ + kTravelMm;
    const auto far = [&](const Vec3& p) {
      return Vec3(centre + around * (p - centre).normalized());
    };
    const Vec3 from = at_mm_;
    const auto leg = [&](const auto& at) {
      for (int n = 1; n <= kLegTicks && !stopped(); ++n) (void)tick(at(n / double{kLegTicks}), 0);
    };
    if ((to - from).norm() < kNextMm) {
      leg([&](double share) -> Vec3 { return from + share * (to - from); });
      return;
    }
    const Vec3 a = (from - centre).normalized();
    const Vec3 b = (to - centre).normalized();
    const double angle = std::acos(std::clamp(a.dot(b), -1.0, 1.0));
    const Vec3 aside =
        angle > 3.1 ? Vec3(a.unitOrthogonal()) : Vec3((b - a.dot(b) * a).normalized());
    const auto turned = [&](double share) -> Vec3 {
      return centre + around * (std::cos(share * angle) * a + std::sin(share * angle) * aside);
    };
    leg([&](double share) -> Vec3 { return from + share * (far(from) - from); });
    if (angle > 1e-6) leg(turned);
    leg([&](double share) -> Vec3 { return far(to) + share * (to - far(to)); });
  }
  double tick(const Vec3& mm, std::uint32_t buttons) {
    device::DeviceState state;
    state.time_s = time_s_ = pacer_.next();
    state.position_m = 1e-3 * mm;
    state.buttons = buttons;
    at_mm_ = mm;
    return servo_(state).norm();
  }

  const ExerciseGround& atlas_;
  double finger_mm_;
  const field::FieldQuery& field_;
  const device::ServoFn& servo_;
  std::stop_token stop_;
  device::Pacer pacer_;
  double speed_;
  double farthest_mm_ = 0;
  Vec3 at_mm_ = Vec3::Zero();
  double time_s_ = 0;
  double above_mm_ = 0;
};

namespace {

/// How far what was felt lies from what is usual, as shares of it.
struct Deviation {
  double rest = 0;     ///< of the force at end-diastole
  double systole = 0;  ///< of the force at end-systole
};

/// @param expected [place] what is normal there, in any unit
std::vector<Deviation> deviations(const std::vector<FeltPlace>& felt,
                                  const std::vector<FeltPlace>& expected) {
  std::vector<double> rest;
  std::vector<double> systole;
  for (std::size_t n = 0; n < felt.size(); ++n) {
    rest.push_back(felt[n].diastole_n / expected[n].diastole_n);
    systole.push_back(felt[n].systole_n / expected[n].systole_n);
  }
  const double usual_rest = median(rest);
  const double usual_systole = median(systole);
  std::vector<Deviation> out;
  for (std::size_t n = 0; n < felt.size(); ++n) {
    out.push_back({rest[n] / usual_rest - 1, systole[n] / usual_systole - 1});
  }
  return out;
}

/// What a lesion of a kind feels like on a wall: a direction of length 1 in deviations.
Deviation signature(exercise::LesionKind kind, const palpation::PatchConstants& healthy,
                    double pressure_n_per_m) {
  constexpr double kGrade = 0.5;
  const palpation::Tissue ill = exercise::with_lesion({}, kind, kGrade);
  const double own = palpation::in_tissue({.k_v_n_per_m = healthy.k_v_n_per_m}, ill).k_v_n_per_m;
  const double rest = healthy.k_v_n_per_m + healthy.k_e_rest_n_per_m + pressure_n_per_m;
  const double systole = rest + healthy.k_e_span_n_per_m;
  const double ill_rest = own + ill.alpha * healthy.k_e_rest_n_per_m + pressure_n_per_m;
  const Deviation out{ill_rest / rest - 1,
                      (ill_rest + ill.alpha * healthy.k_e_span_n_per_m) / systole - 1};
  const double length = std::hypot(out.rest, out.systole);
  return {out.rest / length, out.systole / length};
}

/// The kind whose signature a deviation has most of, and how much.
struct Likeness {
  double size = 0;
  exercise::LesionKind kind = exercise::LesionKind::Soft;
};
Likeness likeness(const Deviation& felt, const std::vector<exercise::LesionKind>& kinds,
                  const palpation::PatchConstants& healthy, double pressure_n_per_m) {
  Likeness out{-std::numeric_limits<double>::infinity(), kinds.front()};
  for (const exercise::LesionKind kind : kinds) {
    const Deviation like = signature(kind, healthy, pressure_n_per_m);
    const double size = felt.rest * like.rest + felt.systole * like.systole;
    if (size > out.size) out = {size, kind};
  }
  return out;
}

int button_of(exercise::LesionKind kind, const std::vector<exercise::LesionKind>& kinds) {
  const auto found = std::find(kinds.begin(), kinds.end(), kind);
  return found == kinds.end() ? 0 : static_cast<int>(found - kinds.begin());
}

/// Where a trainee goes of its own choice, in the order of its way.
std::vector<std::uint32_t> chosen_places(const ExerciseGround& atlas, const Skill& skill,
                                         exercise::Random& random) {
  std::vector<std::uint32_t> places =
      spread_places(atlas.ground(), skill.spacing_mm, random.below(1U << 30U));
  // Who has no patience for all goes where chance leads.
  for (std::size_t n = places.size(); n > 1; --n) std::swap(places[n - 1], places[random.below(n)]);
  if (static_cast<int>(places.size()) > skill.most_places) {
    places.resize(static_cast<std::size_t>(skill.most_places));
  }
  return along_a_way(std::move(places), atlas.wall());
}

/// What a trainee makes of what it felt.
class Judgement {
 public:
  /// @param atlas, asked must outlive it
  Judgement(const ExerciseGround& atlas, const exercise::Exercise& asked, bool knows_normal)
      : atlas_(atlas),
        asked_(asked),
        knows_normal_(knows_normal),
        softest_(asked.task == exercise::Task::Threshold || !knows_normal) {}

  /// What is normal at a place, in N/m; without knowledge of it the same everywhere.
  [[nodiscard]] FeltPlace expected(std::uint32_t vertex) const {
    if (!knows_normal_) return {vertex, 1, 1};
    const palpation::PatchConstants& healthy = atlas_.muscle().as_it_is(vertex);
    const double rest =
        healthy.k_v_n_per_m + healthy.k_e_rest_n_per_m + atlas_.muscle().natural().pressure_at(0);
    return {vertex, rest, rest + healthy.k_e_span_n_per_m};
  }

  [[nodiscard]] Likeness likeness_at(const Deviation& deviation, std::uint32_t vertex) const {
    return likeness(deviation, asked_.kinds, atlas_.muscle().as_it_is(vertex),
                    atlas_.muscle().natural().pressure_at(0));
  }

  /// Indices of the places.
  [[nodiscard]] std::vector<std::size_t> most_striking_first(
      const std::vector<Deviation>& found, const std::vector<FeltPlace>& felt) const {
    std::vector<std::size_t> order(found.size());
    for (std::size_t n = 0; n < order.size(); ++n) order[n] = n;
    const auto striking = [&](std::size_t n) {
      return softest_ ? -found[n].rest : likeness_at(found[n], felt[n].vertex).size;
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return striking(a) > striking(b); });
    return order;
  }

  /// Whether a place can be of the same lesion as another.
  [[nodiscard]] bool beside(const FeltPlace& one, const FeltPlace& other) const {
    return (atlas_.wall().mm(one.vertex) - atlas_.wall().mm(other.vertex)).norm() <
           2 * asked_.radius_mm.high;
  }

 private:
  const ExerciseGround& atlas_;
  const exercise::Exercise& asked_;
  bool knows_normal_;
  bool softest_;  ///< the softest places strike most, whatever a lesion would feel like
};

}  // namespace

Trainee::Trainee(const ExerciseGround& atlas, const exercise::Exercise& asked, Options options)
    : atlas_(atlas), asked_(asked), options_(std::move(options)) {}

Trainee::~Trainee() = default;

device::RunReport Trainee::run(const device::ServoFn& servo, std::stop_token stop) {
  const Skill& skill = options_.skill;
  exercise::Random random(options_.seed);
  std::vector<std::uint32_t> places = options_.places;
  if (places.empty()) places = chosen_places(atlas_, skill, random);
  Hand hand(atlas_, asked_.tool_radius_mm, options_.heart_rate_per_min, servo, options_.pace,
            std::move(stop));
  const double beat_s = options_.heart_rate_per_min > 0 ? 60 / options_.heart_rate_per_min
                                                        : atlas_.field()->rr_interval_s();
  const double press_s = 0.75 + 2 * beat_s;
  const Judgement judgement(atlas_, asked_, skill.knows_normal);
  const auto feel = [&](std::uint32_t vertex, int button) {
    FeltPlace place = hand.press(vertex, button);
    place.diastole_n *= 1 + skill.weber * gaussian(random);
    place.systole_n *= 1 + skill.weber * gaussian(random);
    return place;
  };
  std::vector<FeltPlace> felt;
  std::vector<FeltPlace> expected;
  double spent_s = 0;
  // Time for the second looks and the marks is kept.
  const double kept_s = press_s * (skill.second_looks + asked_.lesions + 1);
  for (const std::uint32_t vertex : places) {
    if (hand.stopped() || (!felt.empty() && spent_s + press_s + kept_s > asked_.seconds)) break;
    felt.push_back(feel(vertex, -1));
    expected.push_back(judgement.expected(vertex));
    spent_s += press_s;
  }
  if (felt.empty()) return hand.report();  // stopped before it came to its first place
  std::vector<std::size_t> order = judgement.most_striking_first(deviations(felt, expected), felt);
  for (int n = 0; n < skill.second_looks && n < static_cast<int>(order.size()); ++n) {
    FeltPlace& place = felt[order[static_cast<std::size_t>(n)]];
    const FeltPlace again = feel(place.vertex, -1);
    place.diastole_n = 0.5 * (place.diastole_n + again.diastole_n);
    place.systole_n = 0.5 * (place.systole_n + again.systole_n);
  }
  const std::vector<Deviation> found = deviations(felt, expected);
  order = judgement.most_striking_first(found, felt);
  std::vector<std::size_t> marked;
  for (const std::size_t n : order) {
    if (static_cast<int>(marked.size()) == asked_.lesions || hand.stopped()) break;
    if (std::any_of(marked.begin(), marked.end(),
                    [&](std::size_t m) { return judgement.beside(felt[n], felt[m]); })) {
      continue;
    }
    marked.push_back(n);
    const auto guessed = static_cast<int>(random.below(asked_.kinds.size()));
    (void)feel(felt[n].vertex,
               skill.knows_names
                   ? button_of(judgement.likeness_at(found[n], felt[n].vertex).kind, asked_.kinds)
                   : guessed);
  }
  return hand.report();
}

}  // namespace beatlas::app
