#include "pipeline/ingest/heart_axis.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace beatlas::ingest {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
// Standard deviation of the angle between a view and the axis it was planned through by hand
// [degrees]; operators' planes of one heart differ by about as much.
constexpr double kPlannedDeg = 10;
// Planes this near are planned in one direction; the heart's axis lies mostly 30 degrees and more
// off the patient's.
constexpr double kOneDirectionDeg = 15;

bool shows_heart(const Place& place) {
  return std::any_of(place.cines.begin(), place.cines.end(),
                     [](const ImageSet& set) { return set.ordinary(); });
}

bool turned_normals(const Vec3& a, const Vec3& b) {
  return std::abs(a.dot(b)) < std::cos(kTurnedDeg * kDegree);
}

/// How well a view holds a direction, 0 to 1.
double holds(const Vec3& view, const Vec3& direction) {
  const double off_deg = std::asin(std::min(1.0, std::abs(view.dot(direction)))) / kDegree;
  return std::exp(-0.5 * (off_deg / kPlannedDeg) * (off_deg / kPlannedDeg));
}

/// Normals of the views in a plane's frame of reference.
std::vector<Vec3> views_beside(const Plane& plane, const std::vector<Plane>& planes) {
  const double alike = std::cos(kOneDirectionDeg * kDegree);
  std::vector<Vec3> out;
  for (const Plane& other : planes) {
    const auto cines = std::count_if(other.places.begin(), other.places.end(), shows_heart);
    if (cines == 0 || cines > kMostSlicesOfView || !same_frame(plane.frame, other.frame)) continue;
    const Vec3 normal = other.normal_lps();
    if (std::none_of(out.begin(), out.end(),
                     [&](const Vec3& known) { return std::abs(known.dot(normal)) > alike; })) {
      out.push_back(normal);
    }
  }
  return out;
}

}  // namespace

double axis_evidence(const Plane& plane, const std::vector<Plane>& planes) {
  const std::vector<Vec3> views = views_beside(plane, planes);
  const Vec3 normal = plane.normal_lps();
  double all = 0;
  double met = 0;
  for (std::size_t a = 0; a < views.size(); ++a) {
    for (std::size_t b = a + 1; b < views.size(); ++b) {
      if (!turned_normals(views[a], views[b]) || !turned_normals(views[a], normal) ||
          !turned_normals(views[b], normal)) {
        continue;
      }
      const double weight = views[a].cross(views[b]).squaredNorm();
      all += weight;
      met += weight * holds(views[a], normal) * holds(views[b], normal);
    }
  }
  return all > 0 ? met / all : 0;
}

const char* orientation_told(const Plane& plane) {
  const double along = std::cos(kOneDirectionDeg * kDegree);
  const Vec3 normal = plane.normal_lps().cwiseAbs();
  if (normal.z() > along) return "axial";
  if (normal.y() > along) return "coronal";
  if (normal.x() > along) return "sagittal";
  return "oblique";
}

bool is_oblique(const Plane& plane) {
  return plane.normal_lps().cwiseAbs().maxCoeff() <= std::cos(kOneDirectionDeg * kDegree);
}

bool one_direction(const Plane& a, const Plane& b) {
  return std::abs(a.normal_lps().dot(b.normal_lps())) > std::cos(kOneDirectionDeg * kDegree);
}

bool turned(const Plane& a, const Plane& b) {
  return turned_normals(a.normal_lps(), b.normal_lps());
}

}  // namespace beatlas::ingest
