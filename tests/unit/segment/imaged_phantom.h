#pragma once
#include <utility>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/phantom/render.h"

namespace beatlas::segment::made {

/// A phantom as its scanner shows it, and its labels.
struct ImagedPhantom {
  explicit ImagedPhantom(const phantom::PhantomSpec& spec) : phantom(spec) {
    StageContext context;
    phantom::Rendering rendering = phantom::render(phantom, context);
    exam.stack = std::move(rendering.cine);
    exam.source_format = "dicom";
    truth = std::move(rendering.labels);
  }
  phantom::Phantom phantom;
  Exam exam;
  LabelCycle truth;
};

/// The preset `clinical`, half its field of view about the same middle.
[[nodiscard]] inline phantom::PhantomSpec clinical_part() {
  phantom::PhantomSpec spec = phantom::preset("clinical");
  const Vec3 middle = spec.grid.mm(95.5, 95.5, 0);
  spec.grid.size = {112, 112, 13};
  spec.grid.mm_from_index.translation() += middle - spec.grid.mm(55.5, 55.5, 0);
  return spec;
}

}  // namespace beatlas::segment::made
