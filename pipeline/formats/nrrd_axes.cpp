#include <algorithm>
#include <charconv>
#include <cmath>

#include "pipeline/formats/grid_axes.h"
#include "pipeline/formats/header_text.h"
#include "pipeline/formats/nrrd_header.h"
#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

/// Whether the kind leaves open that the axis is one in space or one of images.
bool plain_kind(const std::string& kind) {
  const std::string name = lower(kind);
  return name.empty() || name == "domain" || name == "space" || name == "none" || name == "???";
}

bool frame_kind(const std::string& kind) { return kind == "list" || kind == "time"; }

/// Whether the axis points along time alone (spaces with a fourth dimension).
bool along_time(const NrrdAxis& axis) {
  return axis.direction.size() == 4 && axis.direction[3] != 0 && axis.direction[0] == 0 &&
         axis.direction[1] == 0 && axis.direction[2] == 0;
}

bool has_directions(const NrrdFields& fields) {
  return std::any_of(fields.axes.begin(), fields.axes.end(),
                     [](const NrrdAxis& axis) { return !axis.direction.empty(); });
}

/// What marks an axis as one that does not lie in space, the strongest sign there is.
bool outside_space(const NrrdFields& fields, const NrrdAxis& axis) {
  if (has_directions(fields)) return axis.direction.empty() || along_time(axis);
  const bool kinds = std::any_of(fields.axes.begin(), fields.axes.end(),
                                 [](const NrrdAxis& other) { return !plain_kind(other.kind); });
  if (kinds) return !plain_kind(axis.kind);
  const bool gaps = std::any_of(fields.axes.begin(), fields.axes.end(),
                                [](const NrrdAxis& other) { return std::isfinite(other.spacing); });
  if (gaps && std::count_if(fields.axes.begin(), fields.axes.end(), [](const NrrdAxis& other) {
                return !std::isfinite(other.spacing);
              }) == 1) {
    return !std::isfinite(axis.spacing);
  }
  return &axis == &fields.axes[3];
}

double to_mm(const std::string& unit) {
  const std::string name = lower(unit);
  if (name == "m" || name == "meter" || name == "metre") return 1000;
  if (name == "cm") return 10;
  if (name == "um" || name == "micron") return 1e-3;
  return 1;
}

/// Seconds of a unit of time; 0 for anything else.
double to_seconds(const std::string& unit) {
  const std::string name = lower(unit);
  if (name == "s" || name == "sec" || name == "second" || name == "seconds") return 1;
  if (name == "ms" || name == "msec" || name == "millisecond" || name == "milliseconds") {
    return 1e-3;
  }
  if (name == "us" || name == "usec" || name == "microsecond" || name == "microseconds") {
    return 1e-6;
  }
  return 0;
}

/// Numbers between blanks or commas; empty unless there are `count`, all finite.
std::vector<double> list_of(std::string text, std::int64_t count) {
  std::replace(text.begin(), text.end(), ',', ' ');
  std::vector<double> out;
  for (const std::string_view word : words(text)) {
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
      return {};
    out.push_back(value);
  }
  return std::ssize(out) == count ? out : std::vector<double>{};
}

std::string key(const NrrdFields& fields, const std::string& name) {
  const auto found = fields.keys.find(name);
  return found == fields.keys.end() ? std::string() : found->second;
}

/// What the axis is if it cannot be time; empty if it can.
std::string other_axis(const NrrdFields& fields, const NrrdAxis& axis) {
  if (key(fields, "modality") == "DWMRI" || fields.keys.count("DWMRI_b-value") != 0 ||
      fields.keys.count("DWMRI_gradient_0000") != 0) {
    return "a diffusion weighting";
  }
  const std::string kind = lower(axis.kind);
  if (kind.find("color") != std::string::npos) return "a colour";
  if (!plain_kind(kind) && !frame_kind(kind)) return "the components of a voxel";
  return {};
}

/// From voxel to voxel of an axis in space, in the file's unit.
Vec3 direction_in_space(const NrrdAxis& axis) {
  if (axis.direction.size() < 3) throw_invalid("its space has fewer than three dimensions");
  if (axis.direction.size() > 4 || (axis.direction.size() == 4 && axis.direction[3] != 0)) {
    throw_invalid("an axis of its grid runs through space and time at once");
  }
  return {axis.direction[0], axis.direction[1], axis.direction[2]};
}

double axis_spacing_mm(const NrrdAxis& axis) {
  if (!(axis.spacing > 0 && std::isfinite(axis.spacing))) {
    throw_invalid(
        "its header names no usable voxel size (\"space directions\", or \"spacings\" above 0)");
  }
  return axis.spacing * to_mm(axis.unit);
}

/// Turns what is in the file's space to LPS, and tells what of it is a guess.
void turn_to_lps(const std::string& space, bool directions, Affine& out, std::string& note) {
  if (space.starts_with("ras") || space.starts_with("right-anterior")) {
    out = Affine(Eigen::Scaling(-1.0, -1.0, 1.0)) * out;
  } else if (space.starts_with("las") || space.starts_with("left-anterior")) {
    out = Affine(Eigen::Scaling(1.0, -1.0, 1.0)) * out;
  } else if (!space.starts_with("lps") && !space.starts_with("left-posterior")) {
    add_sentence(note, directions
                           ? "The file names no anatomical space, its axes x, y, z were taken as "
                             "left, posterior, superior."
                           : "The file holds no orientation, its axes were taken as left, "
                             "posterior, superior.");
  } else if (!directions) {
    add_sentence(note, "The file holds no directions, its axes were taken as those of its space.");
  }
}

void set_times(const NrrdFields& fields, const NrrdAxis& axis, std::size_t place,
               ImageFileHeader& out) {
  const std::string index = "axis " + std::to_string(place) + " index values";
  out.frame_times_s = list_of(key(fields, index), axis.size);
  std::string unit = axis.unit;
  bool time = lower(axis.kind) == "time" || lower(axis.label).find("time") != std::string::npos;
  if (out.frame_times_s.empty() &&
      lower(key(fields, "MultiVolume.FrameIdentifyingDICOMTagName")) == "triggertime") {
    out.frame_times_s = list_of(key(fields, "MultiVolume.FrameLabels"), axis.size);
    unit = key(fields, "MultiVolume.FrameIdentifyingDICOMTagUnits");
    time = true;
  }
  double step = along_time(axis) ? std::abs(axis.direction[3]) : axis.spacing;
  if (along_time(axis)) {
    time = true;
    if (fields.space_units.size() == 4) unit = fields.space_units[3];
  }
  const double seconds = to_seconds(unit);
  time = time || seconds > 0;
  if (!unit.empty() && seconds == 0 && !out.frame_times_s.empty()) {
    out.frame_times_s.clear();  // degrees, or what else the images differ by
    step = 0;
    time = false;
  }
  if (std::isfinite(step) && step > 0 && out.frame_times_s.empty()) out.frame_interval_s = step;
  const bool told = out.frame_interval_s > 0 || !out.frame_times_s.empty();
  if (time && told) out.frame_axis = FrameAxis::Time;
  if (seconds > 0 && told) {
    out.unit_known = true;
    out.frame_interval_s *= seconds;
    for (double& at : out.frame_times_s) at *= seconds;
  }
}

}  // namespace

int frame_axis_of(const NrrdFields& fields) {
  const std::size_t dimension = fields.axes.size();
  if (dimension > 4) throw_invalid("it has more than four dimensions (x, y, z and time are read)");
  if (dimension < 3) throw_invalid("it has fewer than three dimensions");
  int found = -1;
  int spatial = 0;
  for (std::size_t a = 0; a < dimension; ++a) {
    const NrrdAxis& axis = fields.axes[a];
    const bool outside = dimension == 4 ? outside_space(fields, axis)
                                        : (has_directions(fields) && axis.direction.empty()) ||
                                              !plain_kind(axis.kind);
    if (outside) {
      found = static_cast<int>(a);
      if (dimension == 3 && lower(axis.kind).find("color") != std::string::npos) {
        throw_invalid("it is a colour image, grey values are needed");
      }
    } else {
      ++spatial;
    }
  }
  if (spatial != 3) {
    throw_invalid(std::to_string(spatial) + " of its axes lie in space, three are needed");
  }
  return found;
}

Affine lps_from_index(const NrrdFields& fields, std::string& note) {
  const int frame_axis = frame_axis_of(fields);
  const bool directions = has_directions(fields);
  Affine out = Affine::Identity();
  int column = 0;
  for (int a = 0; a < std::ssize(fields.axes); ++a) {
    if (a == frame_axis) continue;
    const NrrdAxis& axis = fields.axes[static_cast<std::size_t>(a)];
    if (directions) {
      out.linear().col(column) = direction_in_space(axis);
    } else {
      out.linear()(column, column) = axis_spacing_mm(axis);
    }
    ++column;
  }
  if (fields.origin.size() >= 3) {
    out.translation() = Vec3(fields.origin[0], fields.origin[1], fields.origin[2]);
  }
  if (directions && fields.space_units.size() >= 3) {
    out.matrix().topRows<3>() *= to_mm(fields.space_units[0]);
  }
  turn_to_lps(fields.space, directions, out, note);
  return checked_axes(out, note);
}

ImageFileHeader frames_of(const NrrdFields& fields) {
  ImageFileHeader out;
  const int place = frame_axis_of(fields);
  if (place < 0) return out;
  const NrrdAxis& axis = fields.axes[static_cast<std::size_t>(place)];
  if (axis.size < 2) return out;
  out.frame_axis_is = other_axis(fields, axis);
  out.frame_axis = out.frame_axis_is.empty() ? FrameAxis::Untold : FrameAxis::Other;
  if (out.frame_axis == FrameAxis::Untold) {
    set_times(fields, axis, static_cast<std::size_t>(place), out);
  }
  return out;
}

}  // namespace beatlas::formats
