#include "pipeline/phantom/drawn_signal.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "pipeline/phantom/image_faults.h"

namespace beatlas::phantom {
namespace {

constexpr int kN = kDrawnPixels;
using Image = std::vector<float>;  // DrawnSample::kPixels

}  // namespace

bool is_blood(Tissue t) {
  return t == Tissue::LvBlood || t == Tissue::RvBlood || t == Tissue::LaBlood ||
         t == Tissue::RaBlood || t == Tissue::Aorta || t == Tissue::Trunk || t == Tissue::Vessel;
}

bool is_muscle(Tissue t) {
  return t == Tissue::LvMuscle || t == Tissue::Papillary || t == Tissue::RvTrabecula ||
         t == Tissue::Wall;
}

TissueSignals draw_signals(const Family& family) {
  constexpr std::array<const char*, kTissues> kNames{"signal_outside",
                                                     "signal_fat",
                                                     "signal_chest_muscle",
                                                     "signal_bone",
                                                     "signal_lung",
                                                     "signal_liver",
                                                     "signal_spleen",
                                                     "signal_stomach",
                                                     "signal_gas",
                                                     "signal_vessel",
                                                     "signal_mediastinum",
                                                     "signal_other_a",
                                                     "signal_other_b",
                                                     "signal_other_c",
                                                     "signal_other_d",
                                                     "signal_effusion",
                                                     "signal_pericardium",
                                                     nullptr /* LV blood */,
                                                     "signal_muscle",
                                                     nullptr /* papillary */,
                                                     "signal_rv_blood",
                                                     nullptr /* trabecula */,
                                                     "signal_wall",
                                                     "signal_la_blood",
                                                     "signal_ra_blood",
                                                     "signal_aorta",
                                                     nullptr /* trunk */};
  std::array<float, kTissues> out{};
  for (std::size_t t = 0; t < kTissues; ++t) {
    out[t] = kNames[t] != nullptr ? family.number(kNames[t]) : 1.0F;
  }
  auto of = [&](Tissue t) -> float& { return out[static_cast<std::size_t>(t)]; };
  // The RV's and the atria's walls are muscle, mixed with what lies beside them.
  of(Tissue::Wall) = 0.7F * of(Tissue::LvMuscle) + 0.3F * of(Tissue::Wall);
  if (family.happens("random_contrast")) {
    for (std::size_t t = 0; t < kTissues; ++t) {
      out[t] = 1.2F * family.uniform("any_signal", static_cast<std::uint32_t>(t));
    }
    const float least = family.number("least_contrast");
    float& blood = of(Tissue::LvBlood);
    float& muscle = of(Tissue::LvMuscle);
    if (blood < muscle) std::swap(blood, muscle);
    if (blood - muscle < least) blood = muscle + least;
    for (const Tissue t : {Tissue::RvBlood, Tissue::LaBlood, Tissue::RaBlood, Tissue::Aorta}) {
      of(t) = muscle + (blood - muscle) * (0.7F + 0.4F * of(t));
    }
    of(Tissue::Wall) = muscle + 0.2F * (of(Tissue::Wall) - muscle);
  }
  of(Tissue::Papillary) = of(Tissue::LvMuscle);
  of(Tissue::RvTrabecula) = of(Tissue::LvMuscle);
  of(Tissue::Trunk) = of(Tissue::RvBlood);
  return out;
}

namespace {

/// One scanner with one coil and one contrast.
class SliceScanner {
 public:
  explicit SliceScanner(const Family& family)
      : family_(family), signals_(draw_signals(family)), random_(family.seed()), ghost_(family) {
    muscle_uneven_ = family.number("muscle_uneven");
    blood_uneven_ = family.number("blood_uneven");
    tissue_uneven_ = family.number("tissue_uneven");
    blur_ = family.number("blur");
    // A pixel of 2 mm averages two of the acquired ones.
    noise_ = 0.7F / family.number("snr");
    noise_blur_ = family.number("noise_blur");
    gamma_ = family.number("gamma");
    draw_coil();
    draw_texture();
    draw_mask();
  }

  [[nodiscard]] Image image(const TissueImage& tissues) {
    Image out(DrawnSample::kPixels);
    for (std::size_t p = 0; p < DrawnSample::kPixels; ++p) {
      float value = 0;
      for (const auto& place : tissues) value += signals_[static_cast<std::size_t>(place[p])];
      const Tissue tissue = tissues[0][p];
      value *= is_blood(tissue)    ? 1 + blood_uneven_ * coarse_[p]
               : is_muscle(tissue) ? 1 + muscle_uneven_ * fine_[p]
                                   : 1 + tissue_uneven_ * fine_[p];
      out[p] = value / 3;
    }
    flow(tissues, out);
    ghost_.add(out, kN);
    for (std::size_t p = 0; p < DrawnSample::kPixels; ++p) out[p] *= coil_[p];
    blur(out, kN, blur_);
    add_noise(out);
    for (float& value : out) value = std::pow(value, gamma_);
    for (std::size_t p = 0; p < DrawnSample::kPixels; ++p) {
      if (masked_[p] != 0) out[p] = 0;
    }
    return out;
  }

 private:
  void draw_coil() {
    coil_.resize(DrawnSample::kPixels);
    const float factor = std::log(family_.number("shading"));
    const float way = family_.between(0, 6.2832F, "coil_way");
    const float bow = family_.number("coil_bow");
    const float across = family_.number("coil_across");
    float low = 1e9F;
    float high = -1e9F;
    for (std::size_t p = 0; p < DrawnSample::kPixels; ++p) {
      const float x = 2 * static_cast<float>(p % kN) / kN - 1;
      const float y = 2 * static_cast<float>(p / kN) / kN - 1;
      const float s = x * std::cos(way) + y * std::sin(way);
      const float t = -x * std::sin(way) + y * std::cos(way);
      coil_[p] = s + bow * s * s + across * t * t;
      low = std::min(low, coil_[p]);
      high = std::max(high, coil_[p]);
    }
    for (float& value : coil_) value = std::exp(factor * ((value - low) / (high - low) - 0.5F));
  }

  void draw_mask() {
    const BlankedEdge edge(family_);
    masked_.assign(DrawnSample::kPixels, 0);
    for (std::size_t p = 0; p < DrawnSample::kPixels; ++p) {
      masked_[p] = edge.blanks(2 * static_cast<float>(p % kN) / kN - 1,
                               2 * static_cast<float>(p / kN) / kN - 1)
                       ? 1
                       : 0;
    }
  }

  void draw_texture() {
    coarse_.resize(DrawnSample::kPixels);
    fine_.resize(DrawnSample::kPixels);
    const Vec3F off(700 * family_.uniform("texture", 0), 700 * family_.uniform("texture", 1), 0);
    for (std::size_t p = 0; p < DrawnSample::kPixels; ++p) {
      const Vec3F at = off + Vec3F(static_cast<float>(p % kN), static_cast<float>(p / kN), 0);
      coarse_[p] = lattice_noise(at / 7, family_.seed());
      fine_[p] = lattice_noise(at / 3, family_.seed());
    }
  }

  /// Blood that flows fast, or through the slice, loses or gains signal in places.
  void flow(const TissueImage& tissues, Image& image) {
    for (std::uint32_t n = 0; n < 3; ++n) {
      if (!family_.happens("flow_void", n)) continue;
      const auto at =
          static_cast<std::size_t>(family_.uniform("flow_at", n) * DrawnSample::kPixels);
      std::size_t centre = DrawnSample::kPixels;
      for (std::size_t p = 0; p < DrawnSample::kPixels; ++p) {  // The next pixel of blood.
        const std::size_t q = (at + p) % DrawnSample::kPixels;
        if (is_blood(tissues[0][q])) {
          centre = q;
          break;
        }
      }
      if (centre == DrawnSample::kPixels) return;
      std::uniform_real_distribution<float> share(-0.4F, 1.0F);
      const float depth = family_.number("flow_void_depth", n) * share(random_);
      const float radius = family_.number("flow_void_radius", n) / kDrawnPixelMm;
      for (std::size_t p = 0; p < DrawnSample::kPixels; ++p) {
        if (!is_blood(tissues[0][p])) continue;
        const auto dx = static_cast<float>(p % kN) - static_cast<float>(centre % kN);
        const auto dy = static_cast<float>(p / kN) - static_cast<float>(centre / kN);
        image[p] *= 1 - depth * std::exp(-(dx * dx + dy * dy) / (2 * radius * radius));
      }
    }
  }

  void add_noise(Image& image) {
    // Two halves of a complex image (Gudbjartsson 1995); what interpolation smoothed keeps its
    // size.
    std::normal_distribution<float> normal;
    std::array<Image, 2> parts;
    for (Image& part : parts) {
      part.resize(DrawnSample::kPixels);
      for (float& value : part) value = normal(random_);
      if (noise_blur_ > 0.3F) {
        blur(part, kN, noise_blur_);
        for (float& value : part) value *= 3.545F * noise_blur_;
      }
    }
    for (std::size_t p = 0; p < DrawnSample::kPixels; ++p) {
      const float real = image[p] + noise_ * parts[0][p];
      const float imaginary = noise_ * parts[1][p];
      image[p] = std::sqrt(real * real + imaginary * imaginary);
    }
  }

  const Family& family_;
  std::array<float, kTissues> signals_;
  std::mt19937 random_;
  float muscle_uneven_ = 0, blood_uneven_ = 0, tissue_uneven_ = 0;
  float blur_ = 0, noise_ = 0, noise_blur_ = 0, gamma_ = 1;
  Ghost ghost_;
  Image coil_;
  std::vector<std::uint8_t> masked_;
  Image coarse_;  ///< texture in [-1, 1], of blood
  Image fine_;    ///< the same of all else
};

struct Window {
  float low = 0;
  float high = 1;

  [[nodiscard]] float of(float value) const {
    return std::sqrt(std::clamp((value - low) / (high - low), 0.0F, 1.2F));
  }
};

/// The 1st and 99.5th percentile of all values.
Window window_of(const std::vector<Image>& images) {
  Image all;
  for (const Image& image : images) all.insert(all.end(), image.begin(), image.end());
  const auto at = [&](double share) {
    const auto n =
        all.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(all.size() - 1));
    std::nth_element(all.begin(), n, all.end());
    return *n;
  };
  const float low = at(0.01);
  return {low, std::max(at(0.995), low + 1e-6F)};
}

std::uint8_t byte_of(float value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 1.2F) * kDrawnScale));
}

}  // namespace

DrawnSample imaged(const Family& family, const std::vector<TissueImage>& frames, std::size_t shown,
                   const std::array<TissueImage, 2>& neighbours) {
  SliceScanner scanner(family);
  std::vector<Image> images;
  images.reserve(frames.size());
  for (const TissueImage& tissues : frames) images.push_back(scanner.image(tissues));
  const Window window = window_of(images);
  DrawnSample out;
  for (std::size_t b = 0; b < 2; ++b) {
    const Image image = scanner.image(neighbours[b]);
    const Window own = window_of({image});
    for (std::size_t p = 0; p < DrawnSample::kPixels; ++p)
      out.planes[1 + b][p] = byte_of(own.of(image[p]));
  }
  const auto count = static_cast<float>(images.size());
  for (std::size_t p = 0; p < DrawnSample::kPixels; ++p) {
    float sum = 0;
    float squares = 0;
    for (const Image& image : images) {
      const float value = window.of(image[p]);
      sum += value;
      squares += value * value;
    }
    const float mean = sum / count;
    const float deviation = std::sqrt(std::max(0.0F, squares / count - mean * mean));
    out.planes[0][p] = byte_of(window.of(images[shown][p]));
    out.planes[3][p] = byte_of(mean);
    out.planes[4][p] = byte_of(4 * deviation);
    out.planes[5][p] = label_of(frames[shown][0][p]);
  }
  return out;
}

}  // namespace beatlas::phantom
