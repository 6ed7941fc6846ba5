#include "pipeline/phantom/drawn_scanner.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "pipeline/phantom/drawn_signal.h"
#include "pipeline/phantom/drawn_slices.h"
#include "pipeline/phantom/image_faults.h"
#include "pipeline/phantom/noise.h"

namespace beatlas::phantom {
namespace {

constexpr float kMostCounts = 32000;  ///< 16 bit
constexpr int kVoids = 3;
constexpr int kPerLayer = 2;  ///< samples of a voxel

/// A place within a voxel and what it counts. Offsets in pixels, and along the normal in mm.
struct Sub {
  float i = 0, j = 0, mm = 0, weight = 0;
};

/// Two a layer, turned from layer to layer so that no lattice shows.
std::vector<Sub> subs_of(VoxelShape shape, float thickness_mm, float tails) {
  const bool box = shape == VoxelShape::Box;
  const int layers = box ? std::clamp(static_cast<int>(std::ceil(thickness_mm / 2)), 2, 5) : 6;
  std::vector<Sub> out;
  float sum = 0;
  for (int l = 0; l < layers; ++l) {
    const float at = (static_cast<float>(l) + 0.5F) / static_cast<float>(layers) - 0.5F;
    // A profile is followed to two standard deviations.
    const float mm = box ? at * thickness_mm : 4 * at * tails * thickness_mm;
    const float weight = box ? 1.0F : std::exp(-8 * at * at);
    const float turn = 0.6F + 1.1F * static_cast<float>(l);
    for (int q = 0; q < kPerLayer; ++q) {
      const float angle = turn + kPi * static_cast<float>(q);
      out.push_back({0.3F * std::cos(angle), 0.3F * std::sin(angle), mm, weight});
      sum += weight;
    }
  }
  for (Sub& sub : out) sub.weight /= sum;
  return out;
}

/// Of one slice and frame.
using Image = std::vector<float>;

/// Blood that loses or gains signal about a place while it streams.
struct FlowVoid {
  Vec3F at = Vec3F::Zero();
  float radius = 1;
  float depth = 0;
  float when = 0;

  [[nodiscard]] float factor(const Vec3F& lps, float time) const {
    const float beat = std::sin(kPi * (time + when));
    const float far = (lps - at).squaredNorm() / (2 * radius * radius);
    return far > 9 ? 1.0F : 1 - depth * (0.3F + 0.7F * beat * beat) * std::exp(-far);
  }
};

class StackScanner {
 public:
  StackScanner(const Family& family, const DrawnScene& scene, const DrawnStack& stack,
               VoxelShape shape)
      : family_(family),
        scene_(scene),
        stack_(stack),
        shape_(shape),
        signals_(draw_signals(family)),
        subs_(subs_of(shape, stack.thickness_mm, family.number("exam_tails"))),
        ghost_(family) {
    const bool box = shape == VoxelShape::Box;
    muscle_uneven_ = family.number("muscle_uneven");
    blood_uneven_ = family.number("blood_uneven");
    tissue_uneven_ = family.number("tissue_uneven");
    blur_ = family.number(box ? "exam_blur_box" : "exam_blur");
    ringing_ = box ? 0 : family.number("exam_ringing");
    noise_ = 1 / family.number("snr");
    noise_blur_ = family.number("noise_blur");
    gamma_ = family.number("gamma");
    counts_ = family.number("exam_counts");
    draw_coil();
    draw_mask();
    draw_voids();
  }

  /// @param to the cycle's phases, slice k of which is written
  void slice(int k, std::vector<std::vector<float>>& to) const {
    const std::size_t pixels = count();
    const std::vector<Tissue> still = still_tissues(k);
    const std::vector<std::uint8_t> near =
        near_heart(scene_, stack_, k, stack_.shifts[static_cast<std::size_t>(k)], subs_.back().mm);
    std::vector<float> fine(pixels);
    std::vector<float> coarse(pixels);
    std::vector<float> coil(pixels);
    std::vector<Vec3F> places(pixels);
    each_pixel([&](std::size_t at, float i, float j) {
      places[at] = seen(i, j, k, 0);
      fine[at] = lattice_noise(places[at] / 6, family_.seed() ^ 0x81U);
      coarse[at] = lattice_noise(places[at] / 14, family_.seed() ^ 0x82U);
      coil[at] = coil_at(stack_.seen_at(i, j, static_cast<float>(k), Eigen::Vector2f::Zero()));
    });
    for (std::size_t p = 0; p < stack_.times.size(); ++p) {
      const float time = stack_.times[p];
      Image image = signal(k, time, still, fine, coarse, places, near);
      ghost_.add(image, stack_.columns);
      for (std::size_t at = 0; at < pixels; ++at) image[at] *= coil[at];
      sharpen_or_blur(image);
      add_noise(k, static_cast<std::uint32_t>(p), image);
      float* out = to[p].data() + static_cast<std::size_t>(k) * pixels;
      for (std::size_t at = 0; at < pixels; ++at) {
        const float value =
            masked_[at] != 0 ? 0 : counts_ * std::pow(std::max(0.0F, image[at]), gamma_);
        out[at] = std::min(std::round(value), kMostCounts);
      }
    }
  }

 private:
  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(stack_.columns) * static_cast<std::size_t>(stack_.columns);
  }

  [[nodiscard]] Vec3F seen(float i, float j, int k, float mm) const {
    return stack_.seen_at(i, j, static_cast<float>(k), stack_.shifts[static_cast<std::size_t>(k)]) +
           mm * stack_.normal;
  }

  template <class Body>
  void each_pixel(const Body& body) const {
    std::size_t at = 0;
    for (int j = 0; j < stack_.columns; ++j) {
      for (int i = 0; i < stack_.columns; ++i, ++at) {
        body(at, static_cast<float>(i), static_cast<float>(j));
      }
    }
  }

  /// [pixel][sub] of what does not beat.
  [[nodiscard]] std::vector<Tissue> still_tissues(int k) const {
    std::vector<Tissue> out(count() * subs_.size());
    each_pixel([&](std::size_t at, float i, float j) {
      for (std::size_t s = 0; s < subs_.size(); ++s) {
        out[at * subs_.size() + s] =
            scene_.body->at(seen(i + subs_[s].i, j + subs_[s].j, k, subs_[s].mm));
      }
    });
    return out;
  }

  [[nodiscard]] Image signal(int k, float time, const std::vector<Tissue>& still,
                             const std::vector<float>& fine, const std::vector<float>& coarse,
                             const std::vector<Vec3F>& places,
                             const std::vector<std::uint8_t>& near) const {
    Image out(count());
    DrawnHeart::Moment moment;
    if (scene_.heart != nullptr) moment = scene_.heart->moment(contraction_at(time));
    const std::vector<Tissue> heart = heart_tissues(k, moment, near);
    each_pixel([&](std::size_t at, float, float) {
      const float uneven = 1 + tissue_uneven_ * fine[at];
      const float muscle = 1 + muscle_uneven_ * fine[at];
      float blood = 1 + blood_uneven_ * coarse[at];
      for (const FlowVoid& lost : voids_) blood *= lost.factor(places[at], time);
      float value = 0;
      for (std::size_t s = 0; s < subs_.size(); ++s) {
        const Tissue of_heart = near[at] != 0 ? heart[at * subs_.size() + s] : Tissue::Outside;
        const Tissue tissue = of_heart == Tissue::Outside ? still[at * subs_.size() + s] : of_heart;
        value += subs_[s].weight * signals_[static_cast<std::size_t>(tissue)] *
                 (is_blood(tissue)    ? blood
                  : is_muscle(tissue) ? muscle
                                      : uneven);
      }
      out[at] = value;
    });
    return out;
  }

  /// [pixel][sub] of what beats. Where a pixel's first and last layer and those of its neighbours
  /// are of one tissue, so is all of it.
  [[nodiscard]] std::vector<Tissue> heart_tissues(int k, const DrawnHeart::Moment& moment,
                                                  const std::vector<std::uint8_t>& near) const {
    std::vector<Tissue> out(count() * subs_.size(), Tissue::Outside);
    if (scene_.heart == nullptr) return out;
    std::array<std::vector<Tissue>, 2> ends;
    for (std::size_t e = 0; e < 2; ++e) {
      ends[e].assign(count(), Tissue::Outside);
      const float mm = (e == 0 ? subs_.front() : subs_.back()).mm;
      each_pixel([&](std::size_t at, float i, float j) {
        if (near[at] != 0) ends[e][at] = scene_.heart_at(seen(i, j, k, mm), moment);
      });
    }
    const int n = stack_.columns;
    each_pixel([&](std::size_t at, float i, float j) {
      if (near[at] == 0) return;
      bool even = true;
      for (int y = std::max(0, static_cast<int>(j) - 1);
           even && y <= std::min(n - 1, static_cast<int>(j) + 1); ++y) {
        for (int x = std::max(0, static_cast<int>(i) - 1);
             even && x <= std::min(n - 1, static_cast<int>(i) + 1); ++x) {
          const auto beside = static_cast<std::size_t>(y * n + x);
          even = ends[0][beside] == ends[0][at] && ends[1][beside] == ends[0][at];
        }
      }
      for (std::size_t s = 0; s < subs_.size(); ++s) {
        const Sub& sub = subs_[s];
        const Vec3F lps = seen(i + sub.i, j + sub.j, k, sub.mm);
        const Tissue tissue = even ? ends[0][at] : scene_.heart_at(lps, moment);
        out[at * subs_.size() + s] = finer(tissue, lps);
      }
    });
    return out;
  }

  /// Trabeculae that are thinner than the family's: blood between them that no voxel resolves.
  [[nodiscard]] Tissue finer(Tissue tissue, const Vec3F& lps) const {
    if (shape_ == VoxelShape::Box) return tissue;
    if (tissue != Tissue::Papillary && tissue != Tissue::RvTrabecula) return tissue;
    if (lattice_noise(lps / 1.6F, family_.seed() ^ 0x83U) < 0.15F) return tissue;
    return tissue == Tissue::Papillary ? Tissue::LvBlood : Tissue::RvBlood;
  }

  void sharpen_or_blur(Image& image) const {
    if (ringing_ <= 0) return blur(image, stack_.columns, blur_);
    Image wide = image;
    blur(image, stack_.columns, blur_);
    blur(wide, stack_.columns, 1.7F * blur_ + 0.3F);
    for (std::size_t at = 0; at < image.size(); ++at) {
      image[at] += ringing_ * (image[at] - wide[at]);
    }
  }

  /// Two halves of a complex image (Gudbjartsson 1995); what interpolation smoothed keeps its size.
  void add_noise(int k, std::uint32_t phase, Image& image) const {
    Image real(count());
    Image imaginary(count());
    const std::size_t first = static_cast<std::size_t>(stack_.before + k) * count();
    for (std::size_t at = 0; at < count(); ++at) {
      const auto drawn = normal_pair(first + at, phase, family_.seed());
      real[at] = static_cast<float>(drawn[0]);
      imaginary[at] = static_cast<float>(drawn[1]);
    }
    float gain = noise_;
    if (noise_blur_ > 0.4F) {
      blur(real, stack_.columns, noise_blur_);
      blur(imaginary, stack_.columns, noise_blur_);
      gain *= 2 * std::sqrt(kPi) * noise_blur_;
    }
    for (std::size_t at = 0; at < count(); ++at) {
      image[at] = std::hypot(image[at] + gain * real[at], gain * imaginary[at]);
    }
  }

  /// A quadric's exponent, as steep as drawn over the stack, 1 at the heart's middle.
  void draw_coil() {
    coil_way_ = Vec3F(family_.normal("coil_x"), family_.normal("coil_y"), family_.normal("coil_z"))
                    .normalized();
    coil_bow_ = family_.number("coil_bow");
    coil_across_ = family_.number("coil_across");
    float low = 1e9F;
    float high = -1e9F;
    for (const int k : {0, stack_.slices / 2, stack_.slices - 1}) {
      each_pixel([&](std::size_t, float i, float j) {
        const float at =
            coil_exponent(stack_.seen_at(i, j, static_cast<float>(k), Eigen::Vector2f::Zero()));
        low = std::min(low, at);
        high = std::max(high, at);
      });
    }
    coil_gain_ = std::log(family_.number("shading")) / std::max(1e-3F, high - low);
    coil_middle_ = coil_exponent(Vec3F::Zero());
  }
  [[nodiscard]] float coil_exponent(const Vec3F& lps) const {
    const Vec3F at = lps / 150;
    const float s = at.dot(coil_way_);
    return s + coil_bow_ * s * s + coil_across_ * (at.squaredNorm() - s * s);
  }
  [[nodiscard]] float coil_at(const Vec3F& lps) const {
    return std::exp(coil_gain_ * (coil_exponent(lps) - coil_middle_));
  }

  /// What the scanner blanks is never about the heart.
  void draw_mask() {
    const BlankedEdge edge(family_);
    masked_.assign(count(), 0);
    const auto half = 0.5F * static_cast<float>(stack_.columns);
    const int middle = stack_.slices / 2;
    each_pixel([&](std::size_t at, float i, float j) {
      if (!edge.blanks((i + 0.5F) / half - 1, (j + 0.5F) / half - 1)) return;
      const Vec3F place = seen(i, j, middle, 0);
      const Vec3F off = place - place.dot(stack_.normal) * stack_.normal;
      masked_[at] = off.norm() > 0.8F * scene_.heart_reach ? 1 : 0;
    });
  }

  void draw_voids() {
    if (scene_.heart == nullptr) return;
    const DrawnHeart::Moment full = scene_.heart->moment(0);
    for (std::uint32_t n = 0; n < kVoids; ++n) {
      if (!family_.happens("flow_void", n)) continue;
      FlowVoid lost;
      lost.radius = family_.number("flow_void_radius", n);
      lost.depth = family_.number("flow_void_depth", n) * family_.number("flow_way", n);
      lost.when = family_.uniform("flow_when", n);
      constexpr std::uint32_t kTries = 200;
      for (std::uint32_t t = 0; t < kTries; ++t) {
        const std::uint32_t index = 1000 * n + 3 * t;
        lost.at = 0.7F * scene_.heart_reach *
                  Vec3F(family_.between(-1, 1, "flow_at", index),
                        family_.between(-1, 1, "flow_at", index + 1),
                        family_.between(-1, 1, "flow_at", index + 2));
        if (!is_blood(scene_.heart_at(lost.at, full))) continue;
        voids_.push_back(lost);
        break;
      }
    }
  }

  const Family& family_;
  const DrawnScene& scene_;
  const DrawnStack& stack_;
  VoxelShape shape_;
  TissueSignals signals_;
  std::vector<Sub> subs_;
  float muscle_uneven_ = 0, blood_uneven_ = 0, tissue_uneven_ = 0;
  float blur_ = 0, ringing_ = 0, noise_ = 0, noise_blur_ = 0, gamma_ = 1, counts_ = 1000;
  Ghost ghost_;
  Vec3F coil_way_ = Vec3F::UnitX();
  float coil_bow_ = 0, coil_across_ = 0, coil_gain_ = 0, coil_middle_ = 0;
  std::vector<std::uint8_t> masked_;
  std::vector<FlowVoid> voids_;
};

}  // namespace

Cine imaged_stack(const Family& family, const DrawnScene& scene, const DrawnStack& stack,
                  VoxelShape shape, StageContext& context) {
  const StackScanner scanner(family, scene, stack, shape);
  Cine out;
  out.images.grid = stack.grid();
  out.rr_interval_s = stack.rr_interval_s;
  for (const float time : stack.times) out.frame_times_s.push_back(time * stack.rr_interval_s);
  out.images.phases.assign(stack.times.size(), std::vector<float>(out.images.grid.count()));
  parallel_for(static_cast<std::size_t>(stack.slices), context, "slice",
               [&](std::size_t k) { scanner.slice(static_cast<int>(k), out.images.phases); });
  return out;
}

}  // namespace beatlas::phantom
