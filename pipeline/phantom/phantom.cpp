#include "pipeline/phantom/phantom.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "pipeline/phantom/motion.h"
#include "runtime/base/sha256.h"

namespace beatlas::phantom {
namespace {

std::vector<Solid> solids(const HeartShape& shape) {
  std::vector<Solid> out;
  for (Structure structure : kAllStructures) {
    switch (structure) {
      case Structure::Heart:
        out.emplace_back(std::vector<Primitive>{shape.lv_epicardium, Below{shape.lv_base_z_mm},
                                                shape.rv_outer, Below{shape.rv_cut_z_mm}},
                         std::vector<Cell>{{{0, true}, {1, true}}, {{2, true}, {3, true}}});
        break;
      case Structure::LvBlood:
        out.emplace_back(std::vector<Primitive>{shape.lv_cavity, Below{shape.lv_base_z_mm}},
                         std::vector<Cell>{{{0, true}, {1, true}}});
        break;
      case Structure::RvBlood:
        out.emplace_back(
            std::vector<Primitive>{shape.rv_cavity, shape.lv_epicardium, Below{shape.rv_cut_z_mm}},
            std::vector<Cell>{{{0, true}, {1, false}, {2, true}}});
        break;
      case Structure::LvMyocardium:
        out.emplace_back(
            std::vector<Primitive>{shape.lv_epicardium, shape.lv_cavity, Below{shape.lv_base_z_mm}},
            std::vector<Cell>{{{0, true}, {1, false}, {2, true}}});
        break;
    }
  }
  return out;
}

}  // namespace

Frame::Frame(const Anatomy& anatomy, double s)
    : shape_(heart_shape(anatomy, s)),
      lps_from_heart_(phantom::lps_from_heart(anatomy)),
      heart_from_lps_(lps_from_heart_.inverse(Eigen::Isometry)),
      solids_(solids(shape_)) {}

const Solid& Frame::solid(Structure structure) const {
  return solids_[static_cast<std::size_t>(structure)];
}

double Frame::distance_mm(Structure structure, const Vec3& lps) const {
  return solid(structure).nearest(heart_from_lps_ * lps).distance_mm;
}

Nearest Frame::nearest(Structure structure, const Vec3& lps) const {
  Nearest out = solid(structure).nearest(heart_from_lps_ * lps);
  out.point = lps_from_heart_ * out.point;
  out.outward = lps_from_heart_.linear() * out.outward;
  return out;
}

bool Frame::contains(Structure structure, const Vec3& lps) const {
  return solid(structure).contains(heart_from_lps_ * lps);
}

std::uint8_t Frame::label_at(const Vec3& lps) const {
  const Vec3 x = heart_from_lps_ * lps;
  if (!solid(Structure::Heart).contains(x)) return kLabelBackground;
  if (solid(Structure::LvBlood).contains(x)) return kLabelLvBlood;
  if (solid(Structure::LvMyocardium).contains(x)) return kLabelLvMyocardium;
  if (solid(Structure::RvBlood).contains(x)) return kLabelRvBlood;
  return kLabelRestOfHeart;
}

double Frame::volume_ml(Structure structure) const {
  const HeartShape& h = shape_;
  switch (structure) {
    case Structure::Heart:
      return cut_ellipsoid_ml(h.lv_epicardium, h.lv_base_z_mm) +
             cut_ellipsoid_ml(h.rv_outer, h.rv_cut_z_mm) -
             common_ml(h.lv_epicardium, h.rv_outer, std::min(h.lv_base_z_mm, h.rv_cut_z_mm));
    case Structure::LvBlood:
      return cut_ellipsoid_ml(h.lv_cavity, h.lv_base_z_mm);
    case Structure::RvBlood:
      return cut_ellipsoid_ml(h.rv_cavity, h.rv_cut_z_mm) -
             common_ml(h.rv_cavity, h.lv_epicardium, h.rv_cut_z_mm);
    case Structure::LvMyocardium:
      return cut_ellipsoid_ml(h.lv_epicardium, h.lv_base_z_mm) -
             cut_ellipsoid_ml(h.lv_cavity, h.lv_base_z_mm);
  }
  return 0.0;
}

double Frame::crease_distance_mm(Structure structure, const Vec3& lps) const {
  return solid(structure).crease_distance_mm(heart_from_lps_ * lps);
}

std::vector<Vec3> Frame::sample_surface(Structure structure, double spacing_mm) const {
  std::vector<Vec3> points = solid(structure).sample(spacing_mm);
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

double Phantom::distance_mm(Structure structure, const Vec3& lps, double t_s) const {
  return frame(t_s)->distance_mm(structure, lps);
}

bool Phantom::contains(Structure structure, const Vec3& lps, double t_s) const {
  return frame(t_s)->contains(structure, lps);
}

Vec3 Phantom::normal(Structure structure, const Vec3& lps, double t_s) const {
  return frame(t_s)->nearest(structure, lps).outward;
}

double Phantom::velocity_mm_s(Structure structure, const Vec3& lps, double t_s) const {
  constexpr double kHalfStepS = 3e-5;
  return (distance_mm(structure, lps, t_s - kHalfStepS) -
          distance_mm(structure, lps, t_s + kHalfStepS)) /
         (2.0 * kHalfStepS);
}

double Phantom::volume_ml(Structure structure, double t_s) const {
  return frame(t_s)->volume_ml(structure);
}

std::uint8_t Phantom::label_at(const Vec3& lps, double t_s) const {
  return frame(t_s)->label_at(lps);
}

bool Phantom::on_crease(Structure structure, const Vec3& lps, double t_s, double band_mm) const {
  return frame(t_s)->crease_distance_mm(structure, lps) < band_mm;
}

std::vector<Vec3> Phantom::sample_surface(Structure structure, double t_s,
                                          double spacing_mm) const {
  return frame(t_s)->sample_surface(structure, spacing_mm);
}

}  // namespace beatlas::phantom
