#include "runtime/app/exercise_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "runtime/app/exercise_picture.h"
#include "runtime/palpation/segments.h"
#include "runtime/plot/plot.h"
#include "runtime/plot/svg.h"

namespace beatlas::app {
namespace {

using exercise::Task;
using nlohmann::json;

std::string segment_of(const ExerciseGround& atlas, std::uint32_t vertex) {
  return std::string(palpation::segment_name(atlas.wall().map().segment[vertex]));
}

/// A segment's name for people.
std::string words_of(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

/// Of all trials together.
exercise::Palpation whole_palpation(const ExerciseResult& result) {
  exercise::Palpation out;
  double force_ns = 0;
  for (const exercise::Findings& findings : result.findings) {
    const exercise::Palpation& p = findings.palpation;
    out.time_s += p.time_s;
    out.contact_s += p.contact_s;
    out.path_mm += p.path_mm;
    out.harmful_s += p.harmful_s;
    out.peak_n = std::max(out.peak_n, p.peak_n);
    out.share = std::max(out.share, p.share);
    force_ns += p.mean_n * p.contact_s;
  }
  if (out.contact_s > 0) out.mean_n = force_ns / out.contact_s;
  return out;
}

double harmful_of(const KeptSession& session, const ExerciseGround& atlas) {
  return session.exercise.harmful_force_n > 0 ? session.exercise.harmful_force_n
                                              : atlas.harmful_force_n();
}

std::string number(double value, int digits = 3) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

std::string row(const std::string& name, const std::string& value) {
  return "<tr><th>" + name + "</th><td>" + value + "</td></tr>\n";
}

const exercise::Mark& mark_of(const ExerciseResult& result, const exercise::LesionScore& lesion) {
  return result.findings.front().marks[*lesion.mark];
}

std::string lesion_sentence(const ExerciseGround& atlas, const ExerciseResult& result,
                            const exercise::LesionScore& lesion) {
  const exercise::Lesion& hidden = lesion.lesion;
  std::string text = std::string(exercise::lesion_name(hidden.kind)) + " muscle, grade " +
                     number(hidden.grade, 2) + ", radius " + number(hidden.radius_mm, 2) + " mm, " +
                     words_of(segment_of(atlas, hidden.vertex)) + ": ";
  if (!lesion.mark) return text + "missed, without a mark";
  text += (lesion.found ? "found, marked " : "missed, the nearest mark lies ") +
          number(lesion.distance_mm, 2) + " mm away";
  if (!lesion.found) return text;
  return text +
         (lesion.named
              ? ", named rightly"
              : ", named " + std::string(exercise::lesion_name(mark_of(result, lesion).named)));
}

json palpation_json(const exercise::Palpation& p, double harmful_n) {
  return {{"time_s", p.time_s},           {"contact_s", p.contact_s},
          {"path_mm", p.path_mm},         {"share", p.share},
          {"peak_n", p.peak_n},           {"mean_n", p.mean_n},
          {"harmful_force_n", harmful_n}, {"harmful_s", p.harmful_s}};
}

json find_json(const ExerciseGround& atlas, const ExerciseResult& result) {
  json lesions = json::array();
  for (const exercise::LesionScore& lesion : result.score.lesions) {
    json entry = {{"kind", exercise::lesion_name(lesion.lesion.kind)},
                  {"grade", lesion.lesion.grade},
                  {"radius_mm", lesion.lesion.radius_mm},
                  {"segment", segment_of(atlas, lesion.lesion.vertex)},
                  {"found", lesion.found},
                  {"named", lesion.named}};
    if (lesion.mark) {
      entry["distance_mm"] = lesion.distance_mm;
      entry["named_as"] = exercise::lesion_name(mark_of(result, lesion).named);
      entry["mark_s"] = mark_of(result, lesion).time_s;
    }
    lesions.push_back(std::move(entry));
  }
  return {{"points", result.score.points},
          {"false_marks", result.score.false_marks},
          {"lesions", std::move(lesions)}};
}

json threshold_json(const ExerciseGround& atlas, const ExerciseResult& result) {
  json trials = json::array();
  for (const ThresholdTrial& trial : result.trials) {
    json entry = {{"difference", trial.difference},
                  {"segment", segment_of(atlas, trial.place)},
                  {"right", trial.right}};
    if (trial.marked) entry["marked"] = segment_of(atlas, *trial.marked);
    trials.push_back(std::move(entry));
  }
  return {{"threshold", result.threshold.threshold},
          {"low", result.threshold.low},
          {"high", result.threshold.high},
          {"trials", std::move(trials)}};
}

/// Differences that were shown, right and wrong answers apart.
std::string staircase_svg(const ExerciseResult& result) {
  plot::PlotSeries shown{.name = "shown", .x = {}, .y = {}, .dots = true};
  plot::PlotSeries threshold{.name = "threshold", .x = {}, .y = {}, .dashed = true};
  for (std::size_t n = 0; n < result.trials.size(); ++n) {
    const auto trial = static_cast<double>(n + 1);
    const double percent = 100 * result.trials[n].difference;
    shown.x.push_back(trial);
    shown.y.push_back(percent);
    threshold.x.push_back(trial);
    threshold.y.push_back(100 * result.threshold.threshold);
  }
  std::vector<plot::PlotSeries> series{shown, threshold};
  return plot::plots_svg({{.title = "Differences that were shown",
                           .x_title = "trial",
                           .y_title = "softer at rest by [%]",
                           .series = std::move(series),
                           .from_zero = true}});
}

std::string threshold_sentence(const ExerciseResult& result) {
  const exercise::Staircase::Estimate& t = result.threshold;
  return "least difference that is felt: " + number(100 * t.threshold) +
         " % of the stiffness at rest (90 % sure: " + number(100 * t.low) + " to " +
         number(100 * t.high) + " %)";
}

}  // namespace

json result_json(const KeptSession& session, const ExerciseGround& atlas,
                 const ExerciseResult& result) {
  json out = {{"version", 1},
              {"title", session.exercise.title},
              {"task", session.exercise.task == Task::Find ? "find" : "threshold"},
              {"package", session.package},
              {"seed", session.seed},
              {"ticks", result.ticks},
              {"palpation", palpation_json(whole_palpation(result), harmful_of(session, atlas))}};
  if (session.exercise.task == Task::Find) {
    out["find"] = find_json(atlas, result);
  } else {
    out["staircase"] = threshold_json(atlas, result);
  }
  return out;
}

std::string result_text(const KeptSession& session, const ExerciseGround& atlas,
                        const ExerciseResult& result) {
  std::ostringstream text;
  if (session.exercise.task == Task::Find) {
    for (const exercise::LesionScore& lesion : result.score.lesions) {
      text << lesion_sentence(atlas, result, lesion) << "\n";
    }
    if (result.score.false_marks > 0)
      text << "marks of nothing: " << result.score.false_marks << "\n";
    text << number(result.score.points) << " of 100 points\n";
  } else {
    text << threshold_sentence(result) << "\n";
  }
  const exercise::Palpation p = whole_palpation(result);
  text << number(p.time_s) << " s, in contact " << number(p.contact_s) << " s, "
       << number(100 * p.share) << " % of the wall palpated, " << number(p.path_mm / 1000)
       << " m of way, peak " << number(p.peak_n) << " N, mean " << number(p.mean_n) << " N, "
       << number(p.harmful_s) << " s above " << number(harmful_of(session, atlas)) << " N\n";
  return text.str();
}

std::string report_html(const KeptSession& session, const ExerciseGround& atlas,
                        const ExerciseResult& result) {
  const bool find = session.exercise.task == Task::Find;
  const std::string title =
      session.exercise.title.empty() ? "Palpation exercise" : plot::escaped(session.exercise.title);
  std::string page =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" + title +
      "</title>\n<style>body{font:15px/1.5 sans-serif;max-width:62em;margin:2em auto;padding:0 1em;"
      "color:#222}table{border-collapse:collapse}th{text-align:left;font-weight:normal;color:#555;"
      "padding-right:1.5em}h1{font-size:1.5em}h2{font-size:1.15em;margin-top:1.6em}"
      ".result{font-size:1.15em}.key span{display:inline-block;width:1em;height:1em;"
      "border:1px solid #999;margin:0 .3em 0 1em;vertical-align:-.15em}svg{max-width:100%;"
      "height:auto}</style></head><body>\n<h1>" +
      title + "</h1>\n<p class=\"result\">";
  if (find) {
    page += "<b>" + number(result.score.points) + " of 100 points.</b></p>\n<ul>";
    for (const exercise::LesionScore& lesion : result.score.lesions) {
      page += "<li>" + lesion_sentence(atlas, result, lesion) + "</li>\n";
    }
    page += "</ul>\n";
  } else {
    const std::string sentence = threshold_sentence(result);
    page += "<b>" + std::string(1, static_cast<char>(sentence[0] - 'a' + 'A')) +
            sentence.substr(1) + ".</b></p>\n";
  }
  const exercise::Palpation p = whole_palpation(result);
  page += "<h2>How it was palpated</h2>\n<table>\n" + row("time", number(p.time_s) + " s") +
          row("in contact", number(p.contact_s) + " s") +
          row(find ? "share of the reachable wall" : "largest share of the wall in a trial",
              number(100 * p.share) + " %") +
          row("way of the finger in contact", number(p.path_mm / 1000) + " m") +
          row("peak force", number(p.peak_n) + " N") +
          row("mean force in contact", number(p.mean_n) + " N") +
          row("time above the harmful force of " + number(harmful_of(session, atlas)) + " N",
              number(p.harmful_s) + " s") +
          (find ? row("marks of nothing", std::to_string(result.score.false_marks)) : "") +
          row("atlas", plot::escaped(session.package)) + row("seed", std::to_string(session.seed)) +
          "</table>\n";
  PalpationPicture picture;
  picture.under_finger_s.assign(atlas.wall().vertex_count(), 0);
  for (const exercise::Findings& findings : result.findings) {
    for (std::size_t v = 0; v < picture.under_finger_s.size(); ++v) {
      picture.under_finger_s[v] += findings.under_finger_s[v];
    }
  }
  if (find) {
    picture.lesions = result.lesions;
    picture.marks = result.findings.front().marks;
  } else {
    for (const ThresholdTrial& trial : result.trials) {
      if (std::find(picture.places.begin(), picture.places.end(), trial.place) ==
          picture.places.end()) {
        picture.places.push_back(trial.place);
      }
    }
    page += "<h2>The staircase</h2>\n" + staircase_svg(result);
  }
  page += "<h2>Where</h2>\n" + colour_key() + bulls_eye_svg(atlas, picture) +
          wall_svg(atlas, picture) +
          (find ? "<p>Numbers are marks, in their order. The wall is drawn at end-diastole, as the "
                  "cavity is bounded, the base above.</p>\n"
                : "<p>Letters are the places that were compared. The wall is drawn at "
                  "end-diastole, as the cavity is bounded, the base above.</p>\n");
  return page + "</body></html>\n";
}

}  // namespace beatlas::app
