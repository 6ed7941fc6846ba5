#include "pipeline/prior/enlarged.h"

#include <algorithm>
#include <cmath>

#include "pipeline/prior/window.h"

namespace beatlas::prior {

double enlargement(const PriorCycle& looked, const Grid& stack, const ModelCard& card) {
  const auto& [least_ml, most_ml] = card.lv_ml;
  const double lv_ml = least_lv_ml(looked);
  if (lv_ml <= 0 || lv_ml >= least_ml) return 1;
  const double as_fine = card.pixel_mm / stack.spacing_mm().head<2>().maxCoeff();
  return std::max(1.0, std::min(std::cbrt(std::sqrt(least_ml * most_ml) / lv_ml), as_fine));
}

Grid enlarged(Grid grid, double times) {
  grid.mm_from_index.matrix().topRows<3>() *= times;
  return grid;
}

Exam enlarged(Exam exam, double times) {
  exam.stack.images.grid = enlarged(exam.stack.grid(), times);
  for (Cine& view : exam.views) view.images.grid = enlarged(view.grid(), times);
  return exam;
}

}  // namespace beatlas::prior
