#include "pipeline/phantom/phantom.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "pipeline/phantom/motion.h"
#include "runtime/base/sha256.h"

namespace beatlas::phantom {

Frame::Frame(const Anatomy& anatomy, double s)
    : anatomy_(anatomy),
      s_(s),
      shape_(heart_shape(anatomy, s)),
      lps_from_heart_(phantom::lps_from_heart(anatomy)),
      heart_from_lps_(lps_from_heart_.inverse(Eigen::Isometry)) {}

const Solid& Frame::solid(Part part) const {
  Built& built = built_[static_cast<std::size_t>(part)];
  std::call_once(built.solid_once, [&] {
    Construction made = construction(shape_, part);
    built.solid = std::make_unique<const Solid>(std::move(made.primitives), std::move(made.cells));
  });
  return *built.solid;
}

double Frame::surface_speed_mm(PartArgument part, const Vec3& lps) const {
  const Nearest nearest = solid(part).nearest(heart_from_lps_ * lps);
  Built& built = built_[static_cast<std::size_t>(Part(part))];
  std::call_once(built.rates_once, [&] { built.rates = primitive_rates(anatomy_, s_, part); });
  return solid(part).outward_speed(nearest, built.rates);
}

double Frame::distance_mm(PartArgument part, const Vec3& lps) const {
  return solid(part).nearest(heart_from_lps_ * lps).distance_mm;
}

Nearest Frame::nearest(PartArgument part, const Vec3& lps) const {
  Nearest out = solid(part).nearest(heart_from_lps_ * lps);
  out.point = lps_from_heart_ * out.point;
  out.outward = lps_from_heart_.linear() * out.outward;
  return out;
}

bool Frame::contains(PartArgument part, const Vec3& lps) const {
  return solid(part).contains(heart_from_lps_ * lps);
}

std::uint8_t Frame::label_at(const Vec3& lps) const {
  const Vec3 x = heart_from_lps_ * lps;
  if (!solid(Part::Heart).contains(x)) return kLabelBackground;
  if (solid(Part::LvBlood).contains(x)) return kLabelLvBlood;
  if (solid(Part::LvMyocardium).contains(x)) return kLabelLvMyocardium;
  for (const Structure structure :
       {Structure::RvBlood, Structure::LaBlood, Structure::RaBlood, Structure::Aorta}) {
    if (solid(part_of(structure)).contains(x)) return label_of(structure);
  }
  return kLabelRestOfHeart;
}

double Frame::crease_distance_mm(PartArgument part, const Vec3& lps) const {
  return solid(part).crease_distance_mm(heart_from_lps_ * lps);
}

std::vector<Vec3> Frame::sample_surface(PartArgument part, double spacing_mm) const {
  std::vector<Vec3> points = solid(part).sample(spacing_mm);
  for (Vec3& point : points) point = lps_from_heart_ * point;
  return points;
}

struct Phantom::Cache {
  static constexpr std::size_t kFrames = 32;
  std::mutex mutex;
  std::vector<std::pair<double, std::shared_ptr<const Frame>>> frames;  // oldest use first
};

Phantom::Phantom(PhantomSpec spec) : spec_(std::move(spec)), cache_(std::make_shared<Cache>()) {
  check_spec(spec_);
  const std::string text = spec_to_json(spec_).dump();
  identity_ = sha256_hex(std::as_bytes(std::span(text.data(), text.size())));
}

double Phantom::phase_time_s(int phase) const { return spec_.rr_interval_s * phase / spec_.phases; }

std::shared_ptr<const Frame> Phantom::frame(double t_s) const {
  const double s = std::clamp(volume_loss(t_s, spec_.rr_interval_s), 0.0, 1.0);
  const std::scoped_lock lock(cache_->mutex);
  auto& frames = cache_->frames;
  const auto found =
      std::find_if(frames.begin(), frames.end(), [&](const auto& each) { return each.first == s; });
  if (found != frames.end()) {
    std::rotate(found, found + 1, frames.end());
    return frames.back().second;
  }
  if (frames.size() == Cache::kFrames) frames.erase(frames.begin());
  frames.emplace_back(s, std::make_shared<const Frame>(spec_.anatomy, s));
  return frames.back().second;
}

double Phantom::distance_mm(PartArgument part, const Vec3& lps, double t_s) const {
  return frame(t_s)->distance_mm(part, lps);
}

bool Phantom::contains(PartArgument part, const Vec3& lps, double t_s) const {
  return frame(t_s)->contains(part, lps);
}

Vec3 Phantom::normal(PartArgument part, const Vec3& lps, double t_s) const {
  return frame(t_s)->nearest(part, lps).outward;
}

double Phantom::velocity_mm_s(PartArgument part, const Vec3& lps, double t_s) const {
  return frame(t_s)->surface_speed_mm(part, lps) * volume_loss_rate(t_s, spec_.rr_interval_s);
}

double Phantom::volume_ml(PartArgument part, double t_s) const {
  return frame(t_s)->volume_ml(part);
}

std::uint8_t Phantom::label_at(const Vec3& lps, double t_s) const {
  return frame(t_s)->label_at(lps);
}

bool Phantom::on_crease(PartArgument part, const Vec3& lps, double t_s, double band_mm) const {
  return frame(t_s)->crease_distance_mm(part, lps) < band_mm;
}

std::vector<Vec3> Phantom::sample_surface(PartArgument part, double t_s, double spacing_mm) const {
  return frame(t_s)->sample_surface(part, spacing_mm);
}

}  // namespace beatlas::phantom
