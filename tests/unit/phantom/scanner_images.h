#pragma once
/// What the tests of the scanner share: a coarse phantom, its images, and the signal of a point.

#include <cmath>
#include <limits>
#include <vector>

#include "pipeline/phantom/acquisition.h"
#include "pipeline/phantom/moving.h"
#include "pipeline/phantom/render.h"
#include "pipeline/phantom/thorax.h"

namespace beatlas::phantom::test {

/// Without noise; chest and air beside it are in view. @param per_mm size of a voxel along i and j
inline PhantomSpec coarse(double spacing_mm = 4.0) {
  PhantomSpec spec = preset("small");
  spec.scanner.snr_blood = std::numeric_limits<double>::infinity();
  spec.grid = on_matrix(
      spec.grid, {static_cast<int>(272 / spacing_mm), static_cast<int>(232 / spacing_mm), 18},
      {spacing_mm, spacing_mm, 10.0});
  spec.scanner.slice_thickness_mm = 3.0;  // few parts a voxel: fast
  spec.phases = 5;
  return spec;
}

/// The same, each voxel with the signal of its centre.
inline PhantomSpec of_centres(double spacing_mm = 4.0) {
  PhantomSpec spec = coarse(spacing_mm);
  spec.scanner.partial_volume = PartialVolume::None;
  return spec;
}

inline std::vector<std::vector<float>> images_of(const PhantomSpec& spec) {
  StageContext context;
  return render(Phantom(spec), context).cine.images.phases;
}

/// Signal of the tissue at a point of the anatomy, in counts; a reference without any share.
class PointSignal {
 public:
  explicit PointSignal(const Phantom& phantom)
      : phantom_(phantom),
        signals_(signals_preset(phantom.spec().scanner.signals)),
        tissues_(thorax(phantom.spec().anatomy, signals_)) {}

  [[nodiscard]] double at(const Vec3& lps, double t_s) const {
    return at(*phantom_.frame(t_s), lps);
  }
  [[nodiscard]] double at(const Frame& frame, const Vec3& lps) const {
    double signal = signals_.air;
    for (const ThoraxBody& tissue : tissues_) {
      if (tissue.surface(lps).distance_mm < 0.0) signal = tissue.signal;
    }
    for (const MovingBody& body : kMovingBodies) {
      if (!frame.contains(body.part, lps)) continue;
      if (body.layer == Layer::Fat) signal = signals_.fat;
      if (body.layer == Layer::Blood) signal = signals_.blood;
      if (body.layer == Layer::Muscle || body.layer == Layer::Papillary) {
        signal = signals_.myocardium;
      }
    }
    return signal * kBloodCounts;
  }

 private:
  const Phantom& phantom_;
  Signals signals_;
  std::vector<ThoraxBody> tissues_;
};

template <class F>
void for_each_index(const Grid& grid, const F& visit) {
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) visit(i, j, k);
    }
  }
}

}  // namespace beatlas::phantom::test
