#pragma once
#include <optional>
#include <utility>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/phantom/render.h"
#include "pipeline/prior/prior.h"
#include "pipeline/segment/segment.h"

namespace beatlas::segment::made {

/// segment_exam beside what the built-in model says.
[[nodiscard]] Segmentation segmented(const Exam& exam, const std::vector<Seed>& seeds = {},
                                     const SegmentOptions& options = {},
                                     const KnownLabels& known = {});

/// A phantom as its scanner shows it, and its labels.
struct ImagedPhantom {
  explicit ImagedPhantom(const phantom::PhantomSpec& spec) : phantom(spec) {
    StageContext context;
    phantom::Rendering rendering = phantom::render(phantom, context);
    exam.stack = std::move(rendering.cine);
    exam.source_format = "dicom";
    truth = std::move(rendering.labels);
  }

  /// What the built-in model says; asked once, of the images as they are then.
  [[nodiscard]] const prior::PriorCycle& prior() const;
  [[nodiscard]] Segmentation segmented(const std::vector<Seed>& seeds = {},
                                       const SegmentOptions& options = {},
                                       const KnownLabels& known = {}) const {
    StageContext context;
    return segment_exam(exam, seeds, options, context, known, &prior());
  }

  phantom::Phantom phantom;
  Exam exam;
  LabelCycle truth;

 private:
  mutable std::optional<prior::PriorCycle> prior_;
};

/// The preset `clinical`, half its field of view about the same middle.
[[nodiscard]] phantom::PhantomSpec clinical_part();

}  // namespace beatlas::segment::made
