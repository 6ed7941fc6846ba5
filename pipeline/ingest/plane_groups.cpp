#include "pipeline/ingest/plane_groups.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>

#include "pipeline/ingest/cine_contrast.h"
#include "pipeline/ingest/image_runs.h"
#include "pipeline/ingest/slice_resampling.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

// 0.3 mm at the edge of an image.
constexpr double kSameDirection = kSameTurnDeg * std::numbers::pi / 180;
constexpr double kSameStep = 1e-3;  // relative; pixel sizes are printed with 4 digits or more
constexpr int kLeastOfCine = 3;     // images of a slice before their sizes must agree
constexpr std::size_t kMostTimes = 4;
constexpr double kSameTriggerMs = 1;  // magnitude and velocity images are made of the same echoes

/// Matrix and pixel size; of planes and images.
template <class A, class B>
bool same_matrix(const A& a, const B& b) {
  const auto near = [](double one, double other) {
    return std::abs(one - other) <= kSameStep * other;
  };
  return a.columns == b.columns && a.rows == b.rows && near(a.column_step_mm, b.column_step_mm) &&
         near(a.row_step_mm, b.row_step_mm);
}

bool same_plane(const Plane& plane, const DicomImage& image, const std::string& frame) {
  if (!same_frame(plane.frame, frame) || !same_matrix(plane, image) ||
      (plane.row_lps - image.row_lps).norm() >= kSameDirection ||
      (plane.column_lps - image.column_lps).norm() >= kSameDirection) {
    return false;
  }
  const Vec3 offset = image.position_lps - plane.first_lps;
  const Vec3 normal = plane.normal_lps();
  return (offset - normal * normal.dot(offset)).norm() <=
         kSamePixels * std::min(plane.column_step_mm, plane.row_step_mm);
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
  out.first_lps = image.position_lps;
  return out;
}

/// Two sizes within one slice of one series: no choice between them could be right.
void check_sizes(const std::vector<DicomImage>& images, const ImageFiles& files) {
  using Size = std::pair<int, int>;
  using Slice = std::map<Size, std::vector<int>>;
  std::map<std::tuple<std::string, long, long, long, long, long, long>, Slice> slices;
  for (int i = 0; i < static_cast<int>(images.size()); ++i) {
    const DicomImage& image = images[static_cast<std::size_t>(i)];
    const Vec3 normal = image.row_lps.cross(image.column_lps);
    const auto at = [&](int axis) { return std::lround(image.position_lps[axis] / kSamePlaceMm); };
    const auto along = [&](int axis) { return std::lround(normal[axis] / 1e-2); };
    slices[{image.series_uid, at(0), at(1), at(2), along(0), along(1), along(2)}]
          [{image.columns, image.rows}]
              .push_back(i);
  }
  for (const auto& [key, sizes] : slices) {
    std::size_t count = 0;
    for (const auto& [size, members] : sizes) count += members.size();
    if (sizes.size() < 2 || count < kLeastOfCine) continue;
    const auto fewer = [](const auto& a, const auto& b) {
      return a.second.size() < b.second.size();
    };
    const auto odd = std::min_element(sizes.begin(), sizes.end(), fewer);
    const auto usual = std::max_element(sizes.begin(), sizes.end(), fewer);
    const auto text = [](const Size& size) {
      return std::to_string(size.first) + " x " + std::to_string(size.second);
    };
    const DicomImage& image = images[static_cast<std::size_t>(odd->second.front())];
    throw_invalid(files.shown(image.file) + ": it has " + text(odd->first) +
                  " pixels where the other images of its slice have " + text(usual->first) +
                  "; take the odd one out");
  }
}

/// Of frames that were all stored twice (or up to kMostTimes times), one after the other or the
/// whole cycle again, one each; `indices` otherwise. A slice in which nothing moves is no doubled
/// one.
std::vector<int> without_doubles(const std::vector<int>& indices,
                                 const std::vector<DicomImage>& images, const ImageFiles& files) {
  if (!files.fingerprint || indices.size() < 4) return indices;
  std::vector<std::tuple<double, std::string, int>> frames;  // in their own order, copies together
  std::set<std::string> contents;
  for (const int index : indices) {
    const DicomImage& image = images[static_cast<std::size_t>(index)];
    frames.emplace_back(image.stamp.instance.value_or(0), files.fingerprint(image), index);
    contents.insert(std::get<1>(frames.back()));
  }
  if (contents.size() < 2 || contents.count("") > 0) return indices;
  std::sort(frames.begin(), frames.end());
  const std::size_t count = frames.size();
  for (std::size_t times = 2; times <= kMostTimes; ++times) {
    if (count % times != 0) continue;
    for (const bool again : {false, true}) {
      const auto first_of = [&](std::size_t i) {
        return again ? i % (count / times) : i - i % times;
      };
      std::vector<int> out;
      bool doubled = true;
      for (std::size_t i = 0; i < count && doubled; ++i) {
        doubled = std::get<1>(frames[i]) == std::get<1>(frames[first_of(i)]);
        if (first_of(i) == i) out.push_back(std::get<2>(frames[i]));
      }
      if (doubled) return out;
    }
  }
  return indices;
}

std::optional<SliceTiming> timing_of(const std::vector<int>& indices,
                                     const std::vector<DicomImage>& images, double given_rr_s) {
  std::vector<FrameStamp> stamps;
  stamps.reserve(indices.size());
  for (const int index : indices) stamps.push_back(images[static_cast<std::size_t>(index)].stamp);
  return time_slice(stamps, given_rr_s);
}

/// Puts the images in the order of the cycle; false if they have none.
bool set_time(ImageSet& set, const std::vector<DicomImage>& images, const ImageFiles& files) {
  auto timing = timing_of(set.images, images, files.given_rr_s);
  if (!timing || !timing->timed) {
    const std::vector<int> once = without_doubles(set.images, images, files);
    if (once.size() < set.images.size()) {
      const std::size_t left = set.images.size() - once.size();
      set.images = once;
      timing = timing_of(once, images, files.given_rr_s);
      if (timing) {
        timing->note += ", " + std::to_string(left) + " images equal to another were left";
      }
    }
  }
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

/// The same of one acquisition, if there are several.
bool time_one_run(ImageSet& set, const std::vector<DicomImage>& images, const ImageFiles& files) {
  const auto runs = acquisitions_of(set.images, images);
  const std::size_t all = set.images.size();
  set.images = runs[most_complete(runs)];
  if (!set_time(set, images, files)) return false;
  if (runs.size() > 1) {
    set.timing.note +=
        (set.timing.note.empty() ? "the slice was acquired " : ", it was acquired ") +
        std::to_string(runs.size()) +
        " times, the most complete acquisition (of equals the last) was taken, " +
        std::to_string(all - runs[most_complete(runs)].size()) + " images of others were left";
  }
  return true;
}

/// What most images say of themselves.
template <class T>
T most_common(const std::vector<int>& members, const std::vector<DicomImage>& images,
              T DicomImage::*what) {
  std::map<T, int> counts;
  for (const int index : members) ++counts[images[static_cast<std::size_t>(index)].*what];
  return std::max_element(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

/// Whether half of the set's images have the trigger times of some others.
bool same_triggers(const ImageSet& set, const std::vector<int>& others,
                   const std::vector<DicomImage>& images) {
  const auto trigger = [&](int i) { return images[static_cast<std::size_t>(i)].stamp.trigger_ms; };
  const auto met = std::count_if(set.images.begin(), set.images.end(), [&](int own) {
    return trigger(own) && std::any_of(others.begin(), others.end(), [&](int other) {
             return trigger(other) && std::abs(*trigger(other) - *trigger(own)) <= kSameTriggerMs;
           });
  });
  return 2 * met >= set.frames();
}

/// Whether velocities were measured with a set: phase images of the same place, contrast and study
/// are of its series, are as many, or were taken at the same times.
bool is_flow(const ImageSet& set, const std::vector<int>& at_place,
             const std::vector<DicomImage>& images) {
  const std::string& study = images[static_cast<std::size_t>(set.images.front())].study_uid;
  std::map<std::string, std::vector<int>> phase_images;  // by series
  for (const int index : at_place) {
    const DicomImage& image = images[static_cast<std::size_t>(index)];
    if (!image.magnitude && image.contrast == set.contrast && image.study_uid == study) {
      phase_images[image.series_uid].push_back(index);
    }
  }
  return std::any_of(phase_images.begin(), phase_images.end(), [&](const auto& series) {
    return series.first == set.series_uid || series.second.size() == set.images.size() ||
           same_triggers(set, series.second, images);
  });
}

/// What tells the images of one cine from others of its place: series, echo and inversion time,
/// and whether they are secondary copies.
using SetKey = std::tuple<std::string, double, double, bool>;

std::vector<ImageSet> cines_of(const std::vector<int>& indices,
                               const std::vector<DicomImage>& images, const ImageFiles& files) {
  std::map<SetKey, ImageSet> sets;
  const auto add = [](ImageSet& set, int index, const DicomImage& image) {
    set.images.push_back(index);
    set.series_uid = image.series_uid;
    set.series_number = image.series_number;
    set.contrast = image.contrast;
  };
  for (const int index : indices) {
    const DicomImage& image = images[static_cast<std::size_t>(index)];
    if (image.magnitude) {
      add(sets[{image.series_uid, image.contrast.echo_ms, image.contrast.inversion_ms,
                image.provenance == Provenance::Secondary}],
          index, image);
    }
  }
  std::vector<ImageSet> out;
  std::map<SetKey, ImageSet> singles;
  for (auto& [key, set] : sets) {
    const auto kinds = kinds_of(set.images, images);
    if (kinds.size() > 1) {
      for (const std::vector<int>& members : kinds) {
        ImageSet one = set;
        one.images = members;
        one.kind = most_common(members, images, &DicomImage::kind);
        one.kinds = static_cast<int>(kinds.size());
        if (time_one_run(one, images, files)) out.push_back(std::move(one));
      }
    } else if (set.images.size() == 1) {
      ImageSet& merged = singles[{"", std::get<1>(key), std::get<2>(key), std::get<3>(key)}];
      const int index = set.images.front();
      add(merged, index, images[static_cast<std::size_t>(index)]);
      merged.merged = true;
    } else if (time_one_run(set, images, files)) {
      out.push_back(std::move(set));
    }
  }
  if (out.empty()) {
    // Some exports give each phase its own series. Only trigger times can tell that from, say, two
    // stills of one place.
    for (auto& [key, set] : singles) {
      if (set.images.size() > 1 && set_time(set, images, files) && set.timing.by_trigger) {
        out.push_back(std::move(set));
      }
    }
  }
  for (ImageSet& set : out) {
    set.provenance = most_common(set.images, images, &DicomImage::provenance);
    set.flow = is_flow(set, indices, images);
  }
  return out;
}

/// Puts the best set of every place first.
void rank_sets(std::vector<Plane>& planes) {
  const std::optional<Contrast> cine = contrast_of_cines(planes);
  const auto rank = [](const ImageSet& set) {
    return std::make_tuple(set.ordinary(), !set.secondary(), set.usual, set.provenance,
                           set.timing.by_trigger, set.frames(), set.series_number);
  };
  for (Plane& plane : planes) {
    for (Place& place : plane.places) {
      for (ImageSet& set : place.cines) set.usual = !cine || one_protocol(*cine, set.contrast);
      std::stable_sort(place.cines.begin(), place.cines.end(),
                       [&](const ImageSet& a, const ImageSet& b) { return rank(a) > rank(b); });
    }
  }
}

/// Places of the other planes as this one sees them.
std::vector<Place> guests_of(const Plane& plane, const std::vector<Plane>& planes) {
  std::vector<Place> out;
  if (plane.places.empty()) return out;
  const Vec3 normal = plane.normal_lps();
  const Vec3 middle = plane.first_lps +
                      plane.row_lps * (0.5 * (plane.columns - 1) * plane.column_step_mm) +
                      plane.column_lps * (0.5 * (plane.rows - 1) * plane.row_step_mm);
  for (const Plane& other : planes) {
    if (&other == &plane || !could_be_one_stack(plane, other)) continue;
    const Vec3 other_normal = other.normal_lps();
    for (const Place& seen : other.places) {
      if (seen.cines.empty()) continue;
      Place place = seen;
      place.along_mm = normal.dot(middle) +
                       other_normal.dot(place.position_lps - middle) / other_normal.dot(normal);
      place.guest = true;
      out.push_back(std::move(place));
    }
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Place& a, const Place& b) { return a.along_mm < b.along_mm; });
  return out;
}

}  // namespace

Grid lattice_of(const Plane& plane, const Vec3& first_lps, double spacing_mm, int slices) {
  Grid out;
  out.size = {plane.columns, plane.rows, slices};
  out.mm_from_index.linear().col(0) = plane.row_lps * plane.column_step_mm;
  out.mm_from_index.linear().col(1) = plane.column_lps * plane.row_step_mm;
  out.mm_from_index.linear().col(2) = plane.normal_lps() * spacing_mm;
  out.mm_from_index.translation() = first_lps;
  return out;
}

bool nearly_parallel(const Plane& a, const Plane& b) {
  return std::abs(a.normal_lps().dot(b.normal_lps())) >=
         std::cos(kNearlyParallelDeg * std::numbers::pi / 180);
}

bool could_be_one_stack(const Plane& a, const Plane& b) {
  return same_frame(a.frame, b.frame) && nearly_parallel(a, b);
}

bool same_pixels(const Plane& a, const Plane& b) {
  return nearly_parallel(a, b) && same_matrix(a, b);
}

std::vector<Plane> group_planes(const std::vector<DicomImage>& images, const ImageFiles& files) {
  check_sizes(images, files);
  std::vector<Plane> planes;
  std::vector<std::vector<int>> members;
  const std::vector<std::string> frames = files.join_frames
                                              ? std::vector<std::string>(images.size())
                                              : frames_of_reference(images).uids;
  for (int i = 0; i < static_cast<int>(images.size()); ++i) {
    const DicomImage& image = images[static_cast<std::size_t>(i)];
    const std::string& frame = frames[static_cast<std::size_t>(i)];
    std::size_t p = 0;
    while (p < planes.size() && !same_plane(planes[p], image, frame)) ++p;
    if (p == planes.size()) {
      planes.push_back(plane_of(image));
      members.emplace_back();
    }
    if (planes[p].frame.empty()) planes[p].frame = frame;
    members[p].push_back(i);
  }
  for (std::size_t p = 0; p < planes.size(); ++p) {
    Plane& plane = planes[p];
    std::vector<std::vector<int>> at_place;
    for (const int index : members[p]) {
      const Vec3& position = images[static_cast<std::size_t>(index)].position_lps;
      const double along_mm = position.dot(plane.normal_lps());
      std::size_t k = 0;
      while (k < plane.places.size() &&
             std::abs(plane.places[k].along_mm - along_mm) > kSamePlaceMm) {
        ++k;
      }
      if (k == plane.places.size()) {
        Place place;
        place.position_lps = position;
        place.along_mm = along_mm;
        plane.places.push_back(place);
        at_place.emplace_back();
      }
      at_place[k].push_back(index);
    }
    for (std::size_t k = 0; k < plane.places.size(); ++k) {
      plane.places[k].images = static_cast<int>(at_place[k].size());
      plane.places[k].cines = cines_of(at_place[k], images, files);
    }
    std::stable_sort(plane.places.begin(), plane.places.end(),
                     [](const Place& a, const Place& b) { return a.along_mm < b.along_mm; });
  }
  rank_sets(planes);
  for (Plane& plane : planes) plane.guests = guests_of(plane, planes);
  return planes;
}

}  // namespace beatlas::ingest
