#include "pipeline/ingest/plane_groups.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

constexpr double kSameDirection = 1.8e-3;  // radian, 0.1 degree: 0.3 mm at the edge of an image
constexpr double kSameStep = 1e-3;    // relative; pixel sizes are printed with 4 digits or more
constexpr double kSamePlaceMm = 0.1;  // far below any slice gap
constexpr int kLeastOfCine = 3;       // images of a slice before their sizes must agree

bool same_plane(const Plane& plane, const DicomImage& image) {
  const auto near = [](double a, double b) { return std::abs(a - b) <= kSameStep * b; };
  return plane.columns == image.columns && plane.rows == image.rows &&
         near(plane.column_step_mm, image.column_step_mm) &&
         near(plane.row_step_mm, image.row_step_mm) &&
         (plane.row_lps - image.row_lps).norm() < kSameDirection &&
         (plane.column_lps - image.column_lps).norm() < kSameDirection;
}

Plane plane_of(const DicomImage& image) {
  Plane out;
  out.columns = image.columns;
  out.rows = image.rows;
  out.column_step_mm = image.column_step_mm;
  out.row_step_mm = image.row_step_mm;
  out.thickness_mm = image.thickness_mm;
  out.row_lps = image.row_lps;
  out.column_lps = image.column_lps;
  return out;
}

/// Two sizes within one slice of one series: no choice between them could be right.
void check_sizes(const std::vector<DicomImage>& images) {
  struct Slice {
    int first = 0;
    int count = 0;
    int other = -1;
  };
  std::map<std::tuple<std::string, long, long, long, long, long, long>, Slice> slices;
  for (int i = 0; i < static_cast<int>(images.size()); ++i) {
    const DicomImage& image = images[static_cast<std::size_t>(i)];
    const Vec3 normal = image.row_lps.cross(image.column_lps);
    const auto at = [&](int axis) { return std::lround(image.position_lps[axis] / kSamePlaceMm); };
    const auto along = [&](int axis) { return std::lround(normal[axis] / 1e-2); };
    auto [slot, added] = slices.try_emplace(
        {image.series_uid, at(0), at(1), at(2), along(0), along(1), along(2)}, Slice{i, 0, -1});
    Slice& slice = slot->second;
    ++slice.count;
    const DicomImage& first = images[static_cast<std::size_t>(slice.first)];
    if (first.columns != image.columns || first.rows != image.rows) slice.other = i;
  }
  for (const auto& [key, slice] : slices) {
    if (slice.other < 0 || slice.count < kLeastOfCine) continue;
    const DicomImage& a = images[static_cast<std::size_t>(slice.first)];
    const DicomImage& b = images[static_cast<std::size_t>(slice.other)];
    throw_invalid(b.file.string() + ": it has " + std::to_string(b.columns) + " x " +
                  std::to_string(b.rows) + " pixels where another image of its slice has " +
                  std::to_string(a.columns) + " x " + std::to_string(a.rows) +
                  "; take the odd one out");
  }
}

/// Puts the images in the order of the cycle; false if they have none.
bool set_time(ImageSet& set, const std::vector<DicomImage>& images) {
  std::vector<FrameStamp> stamps;
  for (const int index : set.images)
    stamps.push_back(images[static_cast<std::size_t>(index)].stamp);
  auto timing = time_slice(stamps);
  if (!timing) return false;
  std::vector<int> ordered;
  for (int& index : timing->order) {
    ordered.push_back(set.images[static_cast<std::size_t>(index)]);
    index = static_cast<int>(ordered.size()) - 1;
  }
  set.images = ordered;
  set.timing = std::move(*timing);
  return true;
}

std::vector<ImageSet> cines_of(const std::vector<int>& indices,
                               const std::vector<DicomImage>& images) {
  using Contrast = std::tuple<std::string, double, double>;
  std::map<Contrast, ImageSet> sets;
  for (const int index : indices) {
    const DicomImage& image = images[static_cast<std::size_t>(index)];
    if (!image.magnitude) continue;
    ImageSet& set = sets[{image.series_uid, image.echo_ms, image.inversion_ms}];
    set.images.push_back(index);
    set.series_uid = image.series_uid;
    set.series_number = image.series_number;
  }
  std::vector<ImageSet> out;
  std::map<std::pair<double, double>, ImageSet> singles;  // by contrast
  for (auto& [contrast, set] : sets) {
    if (set.images.size() == 1) {
      ImageSet& merged = singles[{std::get<1>(contrast), std::get<2>(contrast)}];
      merged.images.push_back(set.images.front());
      merged.series_uid = set.series_uid;
      merged.series_number = set.series_number;
      merged.merged = true;
    } else if (set_time(set, images)) {
      out.push_back(std::move(set));
    }
  }
  if (out.empty()) {
    // Some exports give each phase its own series. Only trigger times can tell that from, say, two
    // stills of one place.
    for (auto& [contrast, set] : singles) {
      if (set.images.size() > 1 && set_time(set, images) && set.timing.by_trigger) {
        out.push_back(std::move(set));
      }
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const ImageSet& a, const ImageSet& b) {
    return std::make_tuple(a.timing.by_trigger, a.frames(), a.series_number) >
           std::make_tuple(b.timing.by_trigger, b.frames(), b.series_number);
  });
  return out;
}

}  // namespace

std::vector<Plane> group_planes(const std::vector<DicomImage>& images) {
  check_sizes(images);
  std::vector<Plane> planes;
  std::vector<std::vector<int>> members;
  for (int i = 0; i < static_cast<int>(images.size()); ++i) {
    const DicomImage& image = images[static_cast<std::size_t>(i)];
    std::size_t p = 0;
    while (p < planes.size() && !same_plane(planes[p], image)) ++p;
    if (p == planes.size()) {
      planes.push_back(plane_of(image));
      members.emplace_back();
    }
    members[p].push_back(i);
  }
  for (std::size_t p = 0; p < planes.size(); ++p) {
    Plane& plane = planes[p];
    std::vector<std::vector<int>> at_place;
    for (const int index : members[p]) {
      const Vec3& position = images[static_cast<std::size_t>(index)].position_lps;
      std::size_t k = 0;
      while (k < plane.places.size() &&
             (plane.places[k].position_lps - position).norm() > kSamePlaceMm) {
        ++k;
      }
      if (k == plane.places.size()) {
        Place place;
        place.position_lps = position;
        place.along_mm = position.dot(plane.normal_lps());
        plane.places.push_back(place);
        at_place.emplace_back();
      }
      at_place[k].push_back(index);
    }
    for (std::size_t k = 0; k < plane.places.size(); ++k) {
      plane.places[k].images = static_cast<int>(at_place[k].size());
      plane.places[k].cines = cines_of(at_place[k], images);
    }
    std::stable_sort(plane.places.begin(), plane.places.end(),
                     [](const Place& a, const Place& b) { return a.along_mm < b.along_mm; });
  }
  return planes;
}

}  // namespace beatlas::ingest
