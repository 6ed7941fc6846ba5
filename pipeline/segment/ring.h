#pragma once
/// The left ventricle's sign in any slice: a blood pool inside a ring of muscle.

#include <limits>
#include <vector>

#include <opencv2/core.hpp>

namespace beatlas::segment {

/// Intensities that part the tissues.
struct TissueLevels {
  double blood = 0;      ///< typical blood
  double rv_blood = 0;   ///< the right ventricle's blood: coils light it differently
  double muscle = 0;     ///< typical muscle; 0 = not known yet
  double threshold = 0;  ///< between muscle and blood
  double dark = 0;       ///< below it: lung, air
  double fat = std::numeric_limits<double>::infinity();  ///< above it: fat

  /// Sets what lies between, from blood and muscle.
  void part() {
    threshold = 0.5 * (blood + muscle);
    dark = 0.5 * muscle;
  }
};

/// What rays from a point in a blood pool meet. Angle a is 2 pi a / rays, from +column to +row.
struct Ring {
  static constexpr int kRays = 64;
  std::vector<float> endo_mm;   ///< distance to the end of the blood; 0 if the centre is no blood
  std::vector<float> outer_mm;  ///< distance to the outer end of the dark run behind it
  std::vector<char> walled;     ///< the run is as thick as a ventricle's wall
  double walled_share = 0;
  double area_mm2 = 0;   ///< of the polygon of endo_mm
  double roundness = 0;  ///< 1 - deviation / mean of endo_mm

  /// Share of rays with at least a wall's thickness of muscle, seen to its end or not.
  [[nodiscard]] double muscle_share() const;
  /// Median thickness of walled rays [mm]; 0 if there are none.
  [[nodiscard]] double median_wall_mm() const;
};

/// @param image one slice, CV_32F; @param centre_px (column, row)
[[nodiscard]] Ring trace_ring(const cv::Mat& image, const cv::Point2d& pixel_mm,
                              const cv::Point2d& centre_px, const TissueLevels& levels);

/// Point at `radius_mm` along ray `a`, in pixels.
[[nodiscard]] cv::Point2d ray_point(const cv::Point2d& centre_px, const cv::Point2d& pixel_mm,
                                    int a, double radius_mm);

}  // namespace beatlas::segment
