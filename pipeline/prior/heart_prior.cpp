#include <algorithm>
#include <cstdio>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "pipeline/core/parallel.h"
#include "pipeline/prior/across.h"
#include "pipeline/prior/courses.h"
#include "pipeline/prior/crossing_views.h"
#include "pipeline/prior/enlarged.h"
#include "pipeline/prior/network.h"
#include "pipeline/prior/orientations.h"
#include "pipeline/prior/prior.h"
#include "pipeline/prior/slices.h"
#include "pipeline/prior/stored.h"
#include "pipeline/prior/tone.h"
#include "pipeline/prior/window.h"
#include "runtime/atlas/structures.h"
#include "runtime/base/error.h"

namespace beatlas::prior {
namespace {

// Shares of the time.
constexpr double kSeen = 0.1;
constexpr double kLooked = 0.3;
constexpr double kCutAnew = 0.4;  // of what follows the first look

/// Of Dice: by less, an exam is surer in another tone without being righter (the room's README).
constexpr double kSurer = 0.02;

/// Runs networks on slices of phases and keeps what they say.
class Reader {
 public:
  /// @param shown the same slices in one tone or more, whose probabilities are averaged
  /// @param beside images of the exam that are looked at beside these: the more there are in all,
  /// the fewer ways round each is shown
  Reader(const std::vector<SeenSlices>& shown, const Model& model, std::size_t beside = 0)
      : shown_(shown), card_(model.card()), networks_(model), beside_(beside) {}

  void read(const std::vector<int>& phases, const Window& window, int orientations,
            const StageContext& context, PriorCycle& out) {
    const PaddedSize padded = padded_size(window, card_.multiple);
    const auto slices = static_cast<std::size_t>(window.size[2]);
    const Grid& grid = shown_.front().grid;
    const std::size_t voxels = grid.count();
    const TurnsOfImages turns(orientations, beside_ + phases.size() * slices);
    const std::size_t plane =
        static_cast<std::size_t>(padded.width) * static_cast<std::size_t>(padded.height);
    with_quiet_opencv([&] {
      parallel_for(phases.size() * slices, context, "image", [&](std::size_t at) {
        const int p = phases[at / slices];
        const int k = window.first[2] + static_cast<int>(at % slices);
        const std::vector<float> likely = likely_in(window, padded, k, p, turns.of(k, p));
        std::vector<std::int8_t>& phase = out.phases[static_cast<std::size_t>(p)];
        for (std::size_t o = 0; o < card_.outputs.size(); ++o) {
          for (int j = 0; j < window.size[1]; ++j) {
            const float* from =
                likely.data() + o * plane + static_cast<std::ptrdiff_t>(j) * padded.width;
            std::transform(from, from + window.size[0],
                           phase.begin() + static_cast<std::ptrdiff_t>(
                                               o * voxels + grid.offset(window.first[0],
                                                                        window.first[1] + j, k)),
                           stored_log);
          }
        }
      });
    });
  }

 private:
  /// [output][row][column] of one image
  std::vector<float> likely_in(const Window& window, const PaddedSize& padded, int k, int p,
                               const Turns& turns) {
    std::vector<float> out;
    networks_.with([&](Network& network) {
      for (const SeenSlices& seen : shown_) {
        std::vector<float> input;
        fill_input(seen, card_, k, p, window, input);
        std::vector<float> likely;
        run_turned(network, card_, input, padded.width, padded.height, turns, likely);
        if (out.empty()) out.assign(likely.size(), 0);
        for (std::size_t v = 0; v < out.size(); ++v) out[v] += likely[v];
      }
    });
    for (float& likely : out) likely /= static_cast<float>(shown_.size());
    return out;
  }

  const std::vector<SeenSlices>& shown_;
  const ModelCard& card_;
  NetworkPool networks_;
  std::size_t beside_;
};

/// Nothing but background.
std::vector<std::int8_t> no_heart(const std::vector<std::uint8_t>& labels, std::size_t voxels) {
  std::vector<std::int8_t> out(labels.size() * voxels, PriorCycle::kLeast * PriorCycle::kUnits);
  for (std::size_t o = 0; o < labels.size(); ++o) {
    if (labels[o] != kLabelBackground) continue;
    std::fill_n(out.begin() + static_cast<std::ptrdiff_t>(o * voxels), voxels, std::int8_t{0});
  }
  return out;
}

/// Beside what is shown in a tone that is not the usual one, the same in that.
void see_as_usual_too(const Cine& stack, float tone, const ModelCard& card,
                      const StageContext& context, std::vector<SeenSlices>& shown) {
  if (tone != card.tones.front()) {
    shown.push_back(see(stack, card, context, card.tones.front()));
  }
}

/// What the network says of the stack's phases in slices that are cut across the LV.
PriorCycle seen_across(const Cine& stack, const AcrossLv& anew, const Model& model, float tone,
                       const std::vector<int>& phases, const StageContext& context) {
  const ModelCard& card = model.card();
  const Cine cut = cut_anew(stack, anew.grid);
  std::vector<SeenSlices> shown{see(cut, card, context.part(0, kSeen), tone)};
  see_as_usual_too(cut, tone, card, context.part(kSeen, kSeen), shown);
  PriorCycle out{shown.front().grid, card.outputs, {}};
  out.phases.assign(phases.size(), no_heart(out.labels, out.grid.count()));
  Reader(shown, model).read(phases, anew.window, card.orientations, context.part(kSeen, 1), out);
  return out;
}

/// A stack or a view of which some phases were looked at in one tone, each image once.
struct FirstLook {
  float tone = kUsualTone;
  std::vector<SeenSlices> shown;  ///< in this tone
  PriorCycle told;                ///< other phases are empty
};

/// @param part none: the whole
FirstLook look_at(const Cine& stack, const Model& model, float tone,
                  const std::optional<Window>& part, const StageContext& context) {
  const int phases = stack.phase_count();
  if (stack.grid().count() == 0 || phases == 0) {
    throw_invalid("the stack has no images, so nothing in it can be told");
  }
  FirstLook out{tone, {see(stack, model.card(), context.part(0, kSeen / kLooked), tone)}, {}};
  const Grid& grid = out.shown.front().grid;
  out.told = {grid, model.card().outputs, {}};
  out.told.phases.resize(static_cast<std::size_t>(phases));
  const std::vector<int> looked = looked_at(phases);
  for (const int p : looked) {
    out.told.phases[static_cast<std::size_t>(p)] = no_heart(out.told.labels, grid.count());
  }
  Reader(out.shown, model)
      .read(looked, part.value_or(Window{{0, 0, 0}, grid.size}), 1,
            context.part(kSeen / kLooked, 1), out.told);
  return out;
}

/// A look at the stack in the tone in which the network is surest of what it sees: from one tone to
/// the next for as long as it is surer by kSurer.
FirstLook look_in_surest_tone(const Cine& stack, const Model& model, const StageContext& context) {
  const std::vector<float>& tones = model.card().tones;
  const auto part = [&](std::size_t n) {
    const auto all = static_cast<double>(tones.size());
    return context.part(static_cast<double>(n) / all, static_cast<double>(n + 1) / all);
  };
  FirstLook out = look_at(stack, model, tones.front(), std::nullopt, part(0));
  const Window window = window_of_heart(out.told, model.card().multiple);
  double surest = expected_dice(out.told, window);
  for (std::size_t n = 1; n < tones.size(); ++n) {
    FirstLook other = look_at(stack, model, tones[n], window, part(n));
    const double sure = expected_dice(other.told, window);
    if (sure < surest + kSurer) break;
    surest = sure;
    out = std::move(other);
  }
  return out;
}

/// As heart_prior, of one stack or one view. @param beside see Reader
PriorCycle prior_of(const Cine& stack, FirstLook look, const Model& model,
                    const StageContext& context, std::size_t beside = 0) {
  const ModelCard& card = model.card();
  see_as_usual_too(stack, look.tone, card, context.part(0, 0), look.shown);
  Reader reader(look.shown, model, beside);
  PriorCycle out = std::move(look.told);
  const Window window = window_of_heart(out, card.multiple);
  std::vector<int> all(out.phases.size());
  std::iota(all.begin(), all.end(), 0);
  // A model that may not be shown turned slices knows none across the LV either.
  const std::optional<AcrossLv> anew =
      card.orientations > 1 ? across_lv(out, stack.grid(), card) : std::nullopt;
  std::fill(out.phases.begin(), out.phases.end(), no_heart(out.labels, out.grid.count()));
  if (!anew) {
    reader.read(all, window, card.orientations, context, out);
    return out;
  }
  reader.read(all, window, 1, context.part(0, kCutAnew), out);
  mix_in(seen_across(stack, *anew, model, look.tone, all, context.part(kCutAnew, 1)), anew->window,
         out);
  return out;
}

/// Those of an exam's views that cross its stack and beat as it does.
std::vector<std::size_t> crossing_views(const Exam& exam) {
  std::vector<std::size_t> out;
  for (std::size_t n = 0; n < exam.views.size(); ++n) {
    const Cine& view = exam.views[n];
    const bool beats_alike = view.phase_count() == exam.stack.phase_count();
    const bool usable = beats_alike && view.grid().size[2] == 1;
    if (usable && crosses(view.grid(), exam.stack.grid())) out.push_back(n);
  }
  return out;
}

/// What the network says of the stack and of views of it, where it is shown them so many times
/// larger. @param look of the stack
PriorCycle prior_of_exam(const Exam& shown, double larger, FirstLook look,
                         const std::vector<std::size_t>& views, const Model& model,
                         const StageContext& context) {
  const float tone = look.tone;
  const double images = shown.stack.grid().size[2] + static_cast<double>(views.size());
  double done = shown.stack.grid().size[2] / std::max(images, 1.0);
  PriorCycle out = prior_of(shown.stack, std::move(look), model, context.part(0, done));
  out.grid = enlarged(out.grid, 1 / larger);
  std::vector<PriorCycle> told;
  const auto of_stack = static_cast<std::size_t>(shown.stack.grid().size[2]) *
                        static_cast<std::size_t>(shown.stack.phase_count());
  for (const std::size_t n : views) {
    const StageContext part = context.part(done, done + 1 / images);
    const Cine& view = shown.views[n];
    told.push_back(prior_of(view, look_at(view, model, tone, std::nullopt, part.part(0, kLooked)),
                            model, part.part(kLooked, 1), of_stack));
    hold_courses(told.back());
    told.back().grid = enlarged(told.back().grid, 1 / larger);
    done += 1 / images;
  }
  if (shown.views.empty()) return out;
  HeededViews heeded = heed_views(told, out);
  context.log(std::to_string(heeded.views) + " of " + std::to_string(shown.views.size()) +
              " views beside the stack cross it and tell what its slices show.");
  if (heeded.views > 0) out.unknown = std::move(heeded.unknown);
  return out;
}

void tell_tone(const FirstLook& look, const ModelCard& card, const StageContext& context) {
  if (look.tone == card.tones.front()) return;
  char text[160];
  std::snprintf(
      text, sizeof text,
      "The prior is surer of the exam with other middle tones (exponent %g for %g), and is "
      "shown it in both.",
      static_cast<double>(look.tone), static_cast<double>(card.tones.front()));
  context.log(text);
}

}  // namespace

PriorCycle heart_prior(const Exam& exam, const Model& model, StageContext& context) {
  const ModelCard& card = model.card();
  const StageContext first = context.part(0, kLooked);
  const StageContext rest = context.part(kLooked, 1);
  const std::vector<std::size_t> views = crossing_views(exam);
  FirstLook look = look_in_surest_tone(exam.stack, model, first);
  const double larger = enlargement(look.told, exam.stack.grid(), card);
  if (larger <= 1) {
    tell_tone(look, card, context);
    return prior_of_exam(exam, 1, std::move(look), views, model, rest);
  }
  char text[160];
  std::snprintf(text, sizeof text,
                "The left ventricle seems to hold less than %g ml, as none that the prior learned "
                "from; it is shown the exam %.2f times larger.",
                card.lv_ml[0], larger);
  context.log(text);
  const Exam shown = enlarged(exam, larger);
  look = look_in_surest_tone(shown.stack, model, rest.part(0, kLooked));
  tell_tone(look, card, context);
  return prior_of_exam(shown, larger, std::move(look), views, model, rest.part(kLooked, 1));
}

}  // namespace beatlas::prior
