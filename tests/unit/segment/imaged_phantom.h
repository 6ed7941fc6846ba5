#pragma once
#include <optional>
#include <utility>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/phantom/render.h"
#include "pipeline/prior/prior.h"
#include "pipeline/segment/segment.h"

namespace beatlas::made {

/// In how many ways round the built-in model is shown slices: in all where a test asks what the
/// program reaches, in one, a fraction of the time, where it asks what is made of a prior.
enum class Views { One, All };

/// segment::segment_exam beside what the built-in model says.
[[nodiscard]] Segmentation segmented(const Exam& exam, Views views = Views::One,
                                     const std::vector<segment::Seed>& seeds = {},
                                     const segment::SegmentOptions& options = {});

/// A phantom as its scanner shows it, and its labels.
struct ImagedPhantom {
  explicit ImagedPhantom(const phantom::PhantomSpec& spec, Views views = Views::One)
      : phantom(spec), views_(views) {
    StageContext context;
    phantom::Rendering rendering = phantom::render(phantom, context);
    exam.stack = std::move(rendering.cine);
    exam.source_format = "dicom";
    truth = std::move(rendering.labels);
  }

  /// What the built-in model says; asked once, of the images as they are then.
  [[nodiscard]] const prior::PriorCycle& prior() const;
  [[nodiscard]] Segmentation segmented(const std::vector<segment::Seed>& seeds = {},
                                       const segment::SegmentOptions& options = {},
                                       const segment::KnownLabels& known = {}) const {
    StageContext context;
    return segment::segment_exam(exam, seeds, options, context, known, &prior());
  }

  phantom::Phantom phantom;
  Exam exam;
  LabelCycle truth;

 private:
  Views views_;
  mutable std::optional<prior::PriorCycle> prior_;
};

}  // namespace beatlas::made
