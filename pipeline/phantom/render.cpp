#include "pipeline/phantom/render.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "pipeline/core/parallel.h"
#include "pipeline/phantom/flow_void.h"
#include "pipeline/phantom/motion.h"
#include "pipeline/phantom/moving.h"
#include "pipeline/phantom/noise.h"
#include "pipeline/phantom/still.h"

namespace beatlas::phantom {
namespace {

constexpr double kMostCounts = 4095.0;  // 12 bit

/// The heart at every moment that some slice of a frame shows; each is made once.
class Hearts {
 public:
  /// @param before hearts of the frame before, of which many may serve again
  Hearts(const PhantomSpec& spec, const std::vector<double>& moments_s, const Hearts* before)
      : spec_(spec) {
    for (const double t : moments_s) losses_.push_back(loss_at(t));
    std::sort(losses_.begin(), losses_.end());
    losses_.erase(std::unique(losses_.begin(), losses_.end()), losses_.end());
    frames_.resize(losses_.size());
    parallel_for(frames_.size(), [&](std::size_t n) {
      if (before != nullptr) frames_[n] = before->find(losses_[n]);
      if (!frames_[n]) frames_[n] = std::make_shared<const Frame>(spec.anatomy, losses_[n]);
    });
  }

  [[nodiscard]] const Frame& at(double t_s) const { return *find(loss_at(t_s)); }

 private:
  /// To 1e-9, which is far less than a distance can tell: so that equal moments are.
  [[nodiscard]] double loss_at(double t_s) const {
    constexpr double kSteps = 1e9;
    const double loss = std::clamp(volume_loss(t_s, spec_.rr_interval_s), 0.0, 1.0);
    return std::round(loss * kSteps) / kSteps;
  }
  [[nodiscard]] std::shared_ptr<const Frame> find(double loss) const {
    const auto found = std::lower_bound(losses_.begin(), losses_.end(), loss);
    if (found == losses_.end() || *found != loss) return nullptr;
    return frames_[static_cast<std::size_t>(found - losses_.begin())];
  }

  const PhantomSpec& spec_;
  std::vector<double> losses_;
  std::vector<std::shared_ptr<const Frame>> frames_;
};

/// A part of a frame.
struct Moment {
  const Frame* frame = nullptr;
  double ejection = 0;  ///< rate, 0..1
  double weight = 0;
};

struct Imager {
  const PhantomSpec& spec;
  const Grid grid;
  const std::vector<SliceAcquisition> slices;
  const Signals signals;
  const CoverOptions options;
  const StillImages still;
  const Affine lps_from_heart;
  const Affine heart_from_lps;

  explicit Imager(const PhantomSpec& of)
      : spec(of),
        grid(of.imaging_grid()),
        slices(acquisition(of)),
        signals(signals_preset(of.scanner.signals)),
        options(cover_options(of.scanner)),
        still(still_images(of, signals, slices, options)),
        lps_from_heart(phantom::lps_from_heart(of.anatomy)),
        heart_from_lps(lps_from_heart.inverse(Eigen::Isometry)) {}

  double counts(double signal, std::size_t voxel, int phase) const {
    double value = signal * kBloodCounts;
    if (std::isfinite(spec.scanner.snr_blood)) {
      const double sigma = kBloodCounts / spec.scanner.snr_blood;
      const auto noise = normal_pair(voxel, static_cast<std::uint32_t>(phase),
                                     static_cast<std::uint32_t>(spec.scanner.noise_seed));
      const double real = value + sigma * noise[0];
      const double imaginary = sigma * noise[1];
      value = std::sqrt(real * real + imaginary * imaginary);
    }
    return std::clamp(std::round(value), 0.0, kMostCounts);
  }

  /// What a frame of a slice is the mean of; while the heart rests, its moments are one.
  std::vector<Moment> moments_of(const SliceAcquisition& slice, int phase,
                                 const Hearts& hearts) const {
    const std::vector<double> times = frame_moments_s(spec, slice, phase);
    const bool jet = spec.scanner.flow_void_share > 0.0;
    std::vector<Moment> out;
    for (const double t : times) {
      const Moment moment{&hearts.at(t), jet ? ejection_rate(t, spec.rr_interval_s) : 0.0,
                          1.0 / static_cast<double>(times.size())};
      const bool same = !out.empty() && out.back().frame == moment.frame &&
                        out.back().ejection == moment.ejection;
      if (same) {
        out.back().weight += moment.weight;
      } else {
        out.push_back(moment);
      }
    }
    return out;
  }

  /// Adds to `more` by how much the heart's signal at a moment exceeds what lies behind it.
  void add_heart(const Moment& moment, const Grid& moved, const Block& tile,
                 std::vector<float>& more) const {
    const Frame& frame = *moment.frame;
    const double lost = spec.scanner.flow_void_share * moment.ejection;
    const double weight = moment.weight;
    const JetCone jet = jet_cone(frame.shape(), spec.anatomy.scale);
    cover(moved, tile, moving_bodies(frame, lps_from_heart), options,
          [&](const Block& block, const Shares& shares) {
            const auto end = shares.begin() + kMovingBodies.size();
            if (std::all_of(shares.begin(), end, [](float share) { return share == 0.0F; })) return;
            for_each_voxel(block, [&](int i, int j, int k) {
              const double blood =
                  signals.blood *
                  (lost > 0.0 ? 1.0 - lost * jet_weight(jet, heart_from_lps * moved.mm(i, j, k))
                              : 1.0);
              const std::size_t voxel = grid.offset(i, j, k);
              const double behind = still.behind[voxel];
              more[voxel] += static_cast<float>(
                  weight * (moving_signal(shares, behind, blood, signals) - behind));
            });
          });
  }

  /// @param image zeros at first
  void image(const Hearts& hearts, const Block& tile, int phase, std::vector<float>& image) const {
    const SliceAcquisition& slice = slices[static_cast<std::size_t>(tile.first[2])];
    const Grid moved = shifted_grid(grid, slice);
    for (const Moment& moment : moments_of(slice, phase, hearts)) {
      add_heart(moment, moved, tile, image);
    }
    for_each_voxel(tile, [&](int i, int j, int k) {
      const std::size_t voxel = grid.offset(i, j, k);
      double signal = static_cast<double>(still.behind[voxel]) + image[voxel];
      if (!still.bias.empty()) signal *= still.bias[voxel];
      if (!still.arms.empty()) signal += still.arms[voxel];
      image[voxel] = static_cast<float>(counts(signal, voxel, phase));
    });
  }

  void label(const Frame& frame, const Block& tile, std::vector<std::uint8_t>& labels) const {
    const Vec3 size(tile.size[0] - 1, tile.size[1] - 1, tile.size[2] - 1);
    const Vec3 middle = Vec3(tile.first[0], tile.first[1], tile.first[2]) + 0.5 * size;
    const double radius = 0.5 * grid.spacing_mm().cwiseProduct(size).norm();
    if (frame.distance_mm(Structure::Heart, grid.mm_from_index * middle) > radius) return;
    for_each_voxel(tile, [&](int i, int j, int k) {
      labels[grid.offset(i, j, k)] = frame.label_at(grid.mm(i, j, k));
    });
  }
};

}  // namespace

Rendering render(const Phantom& phantom, StageContext& context) {
  const PhantomSpec& spec = phantom.spec();
  const Imager imager(spec);
  const Grid& grid = imager.grid;
  Rendering out;
  out.cine.images.grid = grid;
  out.labels.grid = grid;
  out.cine.rr_interval_s = spec.rr_interval_s;
  const std::vector<Block> tiles = tiles_of(grid);
  const std::vector<Block> small_tiles = blocks_of(grid, {16, 16, 1});
  std::unique_ptr<const Hearts> before;
  for (int phase = 0; phase < spec.phases; ++phase) {
    context.check_cancelled();
    std::vector<double> times;
    for (const SliceAcquisition& slice : imager.slices) {
      for (const double t : frame_moments_s(spec, slice, phase)) times.push_back(t);
    }
    auto hearts = std::make_unique<const Hearts>(spec, times, before.get());
    std::vector<float> image(grid.count(), 0.0F);
    parallel_for(tiles.size(),
                 [&](std::size_t n) { imager.image(*hearts, tiles[n], phase, image); });
    std::vector<std::uint8_t> labels(grid.count(), kLabelBackground);
    const auto nominal = phantom.frame(phantom.phase_time_s(phase));
    parallel_for(small_tiles.size(),
                 [&](std::size_t n) { imager.label(*nominal, small_tiles[n], labels); });
    before = std::move(hearts);
    out.cine.images.phases.push_back(std::move(image));
    out.labels.phases.push_back(std::move(labels));
    out.cine.frame_times_s.push_back(phantom.phase_time_s(phase));
    context.progress(static_cast<double>(phase + 1) / spec.phases);
  }
  return out;
}

}  // namespace beatlas::phantom
