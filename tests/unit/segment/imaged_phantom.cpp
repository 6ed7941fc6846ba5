#include "tests/unit/segment/imaged_phantom.h"

#include "tests/learned.h"

namespace beatlas::segment::made {

Segmentation segmented(const Exam& exam, const std::vector<Seed>& seeds,
                       const SegmentOptions& options, const KnownLabels& known) {
  const prior::PriorCycle likely = test::learned(exam);
  StageContext context;
  return segment_exam(exam, seeds, options, context, known, &likely);
}

const prior::PriorCycle& ImagedPhantom::prior() const {
  if (!prior_) prior_ = test::learned(exam);
  return *prior_;
}

phantom::PhantomSpec clinical_part() {
  phantom::PhantomSpec spec = phantom::preset("clinical");
  const Vec3 middle = spec.grid.mm(95.5, 95.5, 0);
  spec.grid.size = {112, 112, 13};
  spec.grid.mm_from_index.translation() += middle - spec.grid.mm(55.5, 55.5, 0);
  return spec;
}

}  // namespace beatlas::segment::made
