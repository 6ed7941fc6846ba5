#include "pipeline/ingest/dicom_attributes.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace beatlas::ingest {
namespace {

std::optional<double> parsed(std::string text) {
  const auto first = text.find_first_not_of(" +");
  const auto last = text.find_last_not_of(std::string(" \0", 2));
  if (first == std::string::npos || last == std::string::npos || last < first) return std::nullopt;
  double out = 0;
  const char* end = text.data() + last + 1;
  const auto [stop, error] = std::from_chars(text.data() + first, end, out);
  if (error != std::errc() || stop != end) return std::nullopt;
  return out;
}

}  // namespace

const vtkDICOMValue& Attributes::get(vtkDICOMTag tag) const {
  // A classic object may carry an empty per-frame sequence: only ask for frames if there are any.
  if (frames_ > 1) return meta_->Get(0, frame_, tag);
  const vtkDICOMValue& value = meta_->Get(0, tag);
  return value.IsValid() ? value : meta_->Get(0, 0, tag);
}

bool Attributes::has(vtkDICOMTag tag) const {
  const vtkDICOMValue& value = get(tag);
  return value.IsValid() && value.GetVL() > 0;
}

std::optional<double> Attributes::number(vtkDICOMTag tag, std::size_t index) const {
  const vtkDICOMValue& value = get(tag);
  if (!value.IsValid() || value.GetNumberOfValues() <= index) return std::nullopt;
  const bool text = value.GetVR().HasTextValue();
  const auto out = text ? parsed(value.GetString(index)) : std::optional(value.GetDouble(index));
  return out && std::isfinite(*out) ? out : std::nullopt;
}

std::optional<double> Attributes::first(std::initializer_list<vtkDICOMTag> tags) const {
  for (const vtkDICOMTag tag : tags) {
    if (const auto out = number(tag)) return out;
  }
  return std::nullopt;
}

std::optional<Vec3> Attributes::vector(vtkDICOMTag tag, std::size_t first) const {
  Vec3 out;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto value = number(tag, first + i);
    if (!value) return std::nullopt;
    out[static_cast<Eigen::Index>(i)] = *value;
  }
  return out;
}

std::string Attributes::text(vtkDICOMTag tag) const {
  const vtkDICOMValue& value = get(tag);
  return value.IsValid() ? value.AsString() : std::string();
}

std::optional<double> Attributes::time_of_day_s(vtkDICOMTag tag) const {
  const vtkDICOMValue& value = get(tag);
  if (!value.IsValid() || value.GetNumberOfValues() < 1) return std::nullopt;
  std::string time = value.GetString(0);
  if (value.GetVR() == vtkDICOMVR::DT) {  // YYYYMMDDHHMMSS.F&ZZXX
    if (time.size() < 14) return std::nullopt;
    time = time.substr(8, time.find_first_of("+-") - 8);
  }
  if (time.size() < 6 ||
      !std::all_of(time.begin(), time.begin() + 6, [](char c) { return c >= '0' && c <= '9'; })) {
    return std::nullopt;
  }
  const auto seconds = parsed(time.substr(4));
  if (!seconds) return std::nullopt;
  return 3600.0 * std::stoi(time.substr(0, 2)) + 60.0 * std::stoi(time.substr(2, 2)) + *seconds;
}

}  // namespace beatlas::ingest
