#pragma once
/// One frame's attributes, found wherever a classic or multi-frame object keeps them.

#include <initializer_list>
#include <optional>
#include <string>

#include <vtkDICOMMetaData.h>
#include <vtkDICOMValue.h>

#include "runtime/base/geometry.h"

namespace beatlas::ingest {

class Attributes {
 public:
  Attributes(vtkDICOMMetaData* meta, int frame, int frames)
      : meta_(meta), frame_(frame), frames_(frames) {}

  [[nodiscard]] const vtkDICOMValue& get(vtkDICOMTag tag) const;
  /// Whether the attribute is there with a value, whatever that is worth.
  [[nodiscard]] bool has(vtkDICOMTag tag) const;
  /// A finite number; a text that is none ("nan", "1,5") gives nothing, unlike the library's 0.
  [[nodiscard]] std::optional<double> number(vtkDICOMTag tag, std::size_t index = 0) const;
  [[nodiscard]] std::optional<double> first(std::initializer_list<vtkDICOMTag> tags) const;
  [[nodiscard]] std::optional<Vec3> vector(vtkDICOMTag tag, std::size_t first) const;
  [[nodiscard]] std::string text(vtkDICOMTag tag) const;
  /// Seconds of the day of a TM or DT.
  [[nodiscard]] std::optional<double> time_of_day_s(vtkDICOMTag tag) const;

 private:
  vtkDICOMMetaData* meta_;
  int frame_;
  int frames_;
};

}  // namespace beatlas::ingest
