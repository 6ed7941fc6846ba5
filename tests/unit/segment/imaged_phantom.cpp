#include "tests/unit/segment/imaged_phantom.h"

#include "tests/learned.h"

namespace beatlas::segment::made {
namespace {

prior::PriorCycle prior_of(const Exam& exam, Views views) {
  return views == Views::All ? test::learned(exam) : test::learned(exam, BEATLAS_ONE_VIEW_PRIOR);
}

}  // namespace

Segmentation segmented(const Exam& exam, Views views, const std::vector<Seed>& seeds,
                       const SegmentOptions& options) {
  const prior::PriorCycle likely = prior_of(exam, views);
  StageContext context;
  return segment_exam(exam, seeds, options, context, {}, &likely);
}

const prior::PriorCycle& ImagedPhantom::prior() const {
  if (!prior_) prior_ = prior_of(exam, views_);
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
