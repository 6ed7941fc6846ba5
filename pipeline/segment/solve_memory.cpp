#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "pipeline/segment/groundwork.h"

namespace beatlas::segment {
namespace {

// A new member of Chambers or of its axis has to be kept and recalled here too: else a solve that
// begins from what was kept lacks it. The level of fat is none of them: each solve sets it.
static_assert(sizeof(Chambers) == 352);

constexpr std::size_t kRays = Ring::kRays;

using Numbers = std::vector<double>;

/// Numbers read one after the other; past the end zeros, and `good` is false.
class Reader {
 public:
  Reader(const SolveMemory& memory, const std::string& name) {
    const auto found = memory.numbers.find(name);
    if (found != memory.numbers.end()) numbers_ = &found->second;
  }
  double next() {
    if (numbers_ == nullptr || at_ >= numbers_->size()) {
      good_ = false;
      return 0;
    }
    return (*numbers_)[at_++];
  }
  int next_int() {
    constexpr double kMost = 1e6;
    const double value = next();
    if (value >= -kMost && value <= kMost) return static_cast<int>(value);
    good_ = false;
    return 0;
  }
  [[nodiscard]] bool more() const { return numbers_ != nullptr && at_ < numbers_->size(); }
  [[nodiscard]] bool done() const { return good_ && numbers_ != nullptr && !more(); }

 private:
  const Numbers* numbers_ = nullptr;
  std::size_t at_ = 0;
  bool good_ = true;
};

void put(Numbers& out, const Index3& values) {
  for (const int value : values) out.push_back(value);
}

Index3 get_index(Reader& in) {
  Index3 out{};
  for (int& value : out) value = in.next_int();
  return out;
}

void put(Numbers& out, const Vec3& values) {
  for (int a = 0; a < 3; ++a) out.push_back(values[a]);
}

Vec3 get_vector(Reader& in) {
  Vec3 out;
  for (int a = 0; a < 3; ++a) out[a] = in.next();
  return out;
}

void put(Numbers& out, const Ring& ring) {
  out.insert(out.end(), {ring.walled_share, ring.area_mm2, ring.roundness});
  out.insert(out.end(), ring.endo_mm.begin(), ring.endo_mm.end());
  out.insert(out.end(), ring.outer_mm.begin(), ring.outer_mm.end());
  out.insert(out.end(), ring.walled.begin(), ring.walled.end());
}

Ring get_ring(Reader& in) {
  Ring ring;
  ring.walled_share = in.next();
  ring.area_mm2 = in.next();
  ring.roundness = in.next();
  for (std::size_t a = 0; a < kRays; ++a) ring.endo_mm.push_back(static_cast<float>(in.next()));
  for (std::size_t a = 0; a < kRays; ++a) ring.outer_mm.push_back(static_cast<float>(in.next()));
  for (std::size_t a = 0; a < kRays; ++a) ring.walled.push_back(in.next() != 0 ? 1 : 0);
  return ring;
}

/// Slices as one image; those that are empty are zero.
std::vector<std::uint8_t> stacked(const std::vector<cv::Mat>& slices, std::size_t count,
                                  std::size_t slice_count) {
  std::vector<std::uint8_t> out(count * slice_count, 0);
  for (std::size_t k = 0; k < std::min(count, slices.size()); ++k) {
    if (slices[k].empty()) continue;
    const cv::Mat whole = slices[k].isContinuous() ? slices[k] : slices[k].clone();
    std::copy_n(whole.data, slice_count,
                out.begin() + static_cast<std::ptrdiff_t>(k * slice_count));
  }
  return out;
}

std::vector<cv::Mat> unstacked(const Grid& grid, const std::vector<std::uint8_t>& image,
                               bool empty_if_zero) {
  std::vector<cv::Mat> out;
  for (int k = 0; k < grid.size[2]; ++k) {
    const cv::Mat slice = slice_of(grid, image, k);
    out.push_back(empty_if_zero && cv::countNonZero(slice) == 0 ? cv::Mat() : slice.clone());
  }
  return out;
}

void put_chambers(const Chambers& chambers, const Grid& seen_in, SolveMemory& memory) {
  const TissueLevels& levels = chambers.levels;
  memory.numbers["levels"] = {levels.blood, levels.rv_blood, levels.muscle, levels.threshold,
                              levels.dark};
  memory.numbers["chambers"] = {static_cast<double>(chambers.base_step),
                                static_cast<double>(chambers.end_diastole),
                                static_cast<double>(chambers.end_systole), chambers.wall_mm};
  memory.numbers["walls"] = chambers.wall_by_phase_mm;
  Numbers& slices = memory.numbers["slices"];
  Numbers& rings = memory.numbers["rings"];
  for (const LvSlice& slice : chambers.lv) {
    slices.insert(slices.end(),
                  {static_cast<double>(slice.k), slice.centre_px.x, slice.centre_px.y});
    for (const Ring& ring : slice.rings) put(rings, ring);
  }
  const auto count = static_cast<std::size_t>(seen_in.size[2]);
  const std::size_t area = seen_in.slice_count();
  memory.images["masks"] = {
      seen_in,
      {stacked(chambers.always_blood, count, area),
       stacked(chambers.always_blood_moving, count, area), stacked(chambers.rv, count, area)}};
  if (!chambers.axis) return;
  const LongAxis& axis = *chambers.axis;
  Numbers& out = memory.numbers["axis"];
  put(out, axis.origin_mm);
  put(out, axis.towards_base);
  out.push_back(axis.atria ? 1 : 0);
  memory.numbers["apex"] = axis.apex_mm;
  memory.numbers["lv_base"] = axis.lv_base_mm;
  memory.numbers["rv_base"] = axis.rv_base_mm;
}

const Numbers* list_of(const SolveMemory& memory, const std::string& name, std::size_t size) {
  const auto found = memory.numbers.find(name);
  return found != memory.numbers.end() && found->second.size() == size ? &found->second : nullptr;
}

bool get_chambers(const SolveMemory& memory, int phases, const Grid& box_grid, Chambers& out) {
  const auto n = static_cast<std::size_t>(phases);
  Reader levels(memory, "levels");
  out.levels.blood = levels.next();
  out.levels.rv_blood = levels.next();
  out.levels.muscle = levels.next();
  out.levels.threshold = levels.next();
  out.levels.dark = levels.next();
  Reader facts(memory, "chambers");
  out.base_step = facts.next_int();
  out.end_diastole = facts.next_int();
  out.end_systole = facts.next_int();
  out.wall_mm = facts.next();
  const auto is_phase = [&](int phase) { return phase >= 0 && phase < phases; };
  const Numbers* walls = list_of(memory, "walls", n);
  if (!levels.done() || !facts.done() || walls == nullptr || std::abs(out.base_step) != 1 ||
      !is_phase(out.end_diastole) || !is_phase(out.end_systole)) {
    return false;
  }
  out.wall_by_phase_mm = *walls;

  const auto masks = memory.images.find("masks");
  if (masks == memory.images.end() || masks->second.phase_count() != 3) return false;
  const Grid& seen_in = masks->second.grid;
  out.always_blood = unstacked(seen_in, masks->second.phases[0], false);
  out.always_blood_moving = unstacked(seen_in, masks->second.phases[1], false);
  out.rv = unstacked(seen_in, masks->second.phases[2], true);
  Reader slices(memory, "slices");
  Reader rings(memory, "rings");
  while (slices.more()) {
    LvSlice slice;
    slice.k = slices.next_int();
    slice.centre_px.x = slices.next();
    slice.centre_px.y = slices.next();
    for (std::size_t p = 0; p < n; ++p) slice.rings.push_back(get_ring(rings));
    if (slice.k < 0 || slice.k >= seen_in.size[2]) return false;
    out.lv.push_back(std::move(slice));
  }
  if (!slices.done() || !rings.done() || !out.found_lv()) return false;

  if (memory.numbers.count("axis") == 0) return true;
  LongAxis axis;
  Reader in(memory, "axis");
  axis.origin_mm = get_vector(in);
  axis.towards_base = get_vector(in);
  axis.atria = in.next() != 0;
  const Numbers* apex = list_of(memory, "apex", n);
  const Numbers* lv_base = list_of(memory, "lv_base", n);
  const Numbers* rv_base = list_of(memory, "rv_base", n);
  if (!in.done() || apex == nullptr || lv_base == nullptr || rv_base == nullptr) return false;
  axis.apex_mm = *apex;
  axis.lv_base_mm = *lv_base;
  axis.rv_base_mm = *rv_base;
  out.axis = std::move(axis);
  out.height_mm = out.axis->heights_mm(box_grid);
  return true;
}

void put_looked(const std::vector<LvSlices>& looked, SolveMemory& memory) {
  for (std::size_t at = 0; at < looked.size(); ++at) {
    const LvSlices& slices = looked[at];
    const std::string name = "looked_" + std::to_string(at);
    Numbers& grid = memory.numbers[name + "_grid"];
    put(grid, slices.grid.size);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        grid.push_back(slices.grid.mm_from_index.matrix()(row, column));
      }
    }
    memory.numbers[name + "_found"].assign(slices.found.begin(), slices.found.end());
    Numbers& turned = memory.numbers[name + "_turned"];
    turned = {slices.turned ? 1.0 : 0.0, static_cast<double>(slices.doubted.size())};
    turned.insert(turned.end(), slices.doubted.begin(), slices.doubted.end());
    Numbers& adopted = memory.numbers[name + "_adopted"];
    for (const LvPlace& place : slices.adopted) {
      adopted.insert(adopted.end(),
                     {static_cast<double>(place.k), place.centre_px.x, place.centre_px.y});
    }
  }
}

bool get_looked(const SolveMemory& memory, std::vector<LvSlices>& out) {
  for (std::size_t at = 0;; ++at) {
    const std::string name = "looked_" + std::to_string(at);
    if (memory.numbers.count(name + "_grid") == 0) return at > 0;
    LvSlices slices;
    Reader grid(memory, name + "_grid");
    slices.grid.size = get_index(grid);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        slices.grid.mm_from_index.matrix()(row, column) = grid.next();
      }
    }
    Reader found(memory, name + "_found");
    while (found.more()) slices.found.push_back(found.next_int());
    Reader turned(memory, name + "_turned");
    slices.turned = turned.next_int() != 0;
    for (int left = turned.next_int(); left > 0 && turned.more(); --left) {
      slices.doubted.push_back(turned.next_int());
    }
    Reader adopted(memory, name + "_adopted");
    while (adopted.more()) {
      LvPlace place;
      place.k = adopted.next_int();
      place.centre_px.x = adopted.next();
      place.centre_px.y = adopted.next();
      slices.adopted.push_back(place);
    }
    const bool ascending = std::adjacent_find(slices.found.begin(), slices.found.end(),
                                              std::greater_equal<>()) == slices.found.end();
    const bool doubted = std::is_sorted(slices.doubted.begin(), slices.doubted.end());
    if (!grid.done() || !found.done() || !turned.done() || !adopted.done() || !ascending ||
        !doubted) {
      return false;
    }
    out.push_back(std::move(slices));
  }
}

/// The images of that name if they fit the grid; none else.
LabelImages* images_of(SolveMemory& memory, const std::string& name, const Index3& size,
                       std::size_t phases) {
  const auto found = memory.images.find(name);
  if (found == memory.images.end() || found->second.grid.size != size ||
      found->second.phases.size() != phases) {
    return nullptr;
  }
  return &found->second.phases;
}

bool labels_only(const LabelImages& images, bool may_be_unlabelled) {
  return std::all_of(images.begin(), images.end(), [&](const auto& image) {
    return std::all_of(image.begin(), image.end(), [&](std::uint8_t label) {
      return label < TravelCost::kLabels || (may_be_unlabelled && label == kUnlabelled);
    });
  });
}

}  // namespace

SolveMemory kept(const Grid& box_grid, KeptSolve solve) {
  SolveMemory memory;
  Groundwork& ground = solve.ground;
  Numbers& boxes = memory.numbers["boxes"];
  put(boxes, ground.moving.first);
  put(boxes, ground.moving.size);
  put(boxes, ground.box.first);
  put(boxes, ground.box.size);
  memory.numbers["noise"] = {ground.noise};
  put_chambers(ground.chambers, ground.looked.back().grid, memory);
  put_looked(ground.looked, memory);
  memory.images["motion"] = {box_grid, {std::move(ground.motion)}};
  memory.images["automatic"] = {box_grid, std::move(ground.automatic)};
  memory.images["grown"] = {box_grid, std::move(solve.grown)};
  memory.images["drawn"] = {box_grid, std::move(solve.drawn)};
  memory.images["tidied"] = {box_grid, std::move(solve.tidied)};
  memory.images["bounded"] = {box_grid, std::move(solve.bounded)};
  memory.images["smoothed"] = {box_grid, std::move(solve.smoothed)};
  return memory;
}

std::optional<KeptSolve> recall(SolveMemory memory, const Grid& stack, int phases,
                                std::vector<Seed> drawn) {
  KeptSolve out;
  Groundwork& ground = out.ground;
  Reader boxes(memory, "boxes");
  ground.moving.first = get_index(boxes);
  ground.moving.size = get_index(boxes);
  ground.box.first = get_index(boxes);
  ground.box.size = get_index(boxes);
  Reader noise(memory, "noise");
  ground.noise = noise.next();
  if (!boxes.done() || !noise.done()) return {};
  for (const Box& box : {ground.moving, ground.box}) {
    for (std::size_t a = 0; a < 3; ++a) {
      if (box.first[a] < 0 || box.size[a] < 1 || box.size[a] > stack.size[a] - box.first[a]) {
        return {};
      }
    }
  }
  const Box box = box_with_seeds(stack, ground.moving, drawn);
  if (box.first != ground.box.first || box.size != ground.box.size) return {};
  const Grid box_grid = stack.part(box.first, box.size);
  if (!get_chambers(memory, phases, box_grid, ground.chambers)) return {};
  if (!get_looked(memory, ground.looked)) return {};
  for (const LvSlices& slices : ground.looked) {
    if (places_beside(slices.found, slices.grid, drawn) != slices.adopted ||
        turned_by(drawn, slices) != slices.turned) {
      return {};
    }
  }
  const auto n = static_cast<std::size_t>(phases);
  LabelImages* motion = images_of(memory, "motion", box.size, 1);
  LabelImages* automatic = images_of(memory, "automatic", box.size, n);
  LabelImages* grown = images_of(memory, "grown", box.size, n);
  LabelImages* drawn_before = images_of(memory, "drawn", box.size, n);
  LabelImages* tidied = images_of(memory, "tidied", box.size, n);
  LabelImages* bounded = images_of(memory, "bounded", box.size, n);
  LabelImages* smoothed = images_of(memory, "smoothed", box.size, n);
  if (motion == nullptr || automatic == nullptr || grown == nullptr || drawn_before == nullptr ||
      tidied == nullptr || bounded == nullptr || smoothed == nullptr ||
      !labels_only(*automatic, true) || !labels_only(*grown, true) ||
      !labels_only(*drawn_before, true) || !labels_only(*tidied, false) ||
      !labels_only(*bounded, false) || !labels_only(*smoothed, false) ||
      std::any_of(motion->front().begin(), motion->front().end(),
                  [](std::uint8_t motion_class) { return motion_class > kMoving; })) {
    return {};
  }
  ground.motion = std::move(motion->front());
  ground.automatic = std::move(*automatic);
  out.grown = std::move(*grown);
  out.drawn = std::move(*drawn_before);
  out.tidied = std::move(*tidied);
  out.bounded = std::move(*bounded);
  out.smoothed = std::move(*smoothed);
  return out;
}

}  // namespace beatlas::segment
