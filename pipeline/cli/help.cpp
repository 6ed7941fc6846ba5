#include "pipeline/cli/help.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

namespace beatlas::cli {
namespace {

/// CLI11's own but for the synopsis, in which it calls required options optional, too.
class Formatter : public CLI::Formatter {
 public:
  std::string make_usage(const CLI::App* app, std::string name) const override {
    std::string text = CLI::Formatter::make_usage(app, std::move(name));
    const std::string all = "[" + get_label("OPTIONS") + "]";
    const std::size_t at = text.find(all);
    if (at == std::string::npos) return text;
    std::string required;
    for (const CLI::Option* option : app->get_options()) {
      if (!option->nonpositional() || !option->get_required()) continue;
      const bool is_short = !option->get_snames().empty();
      required +=
          is_short ? " -" + option->get_snames().front() : " --" + option->get_lnames().front();
      required += " " + option->get_type_name().substr(0, option->get_type_name().find(':'));
    }
    return text.insert(at + all.size(), required);
  }
};

/// `head`, and below it the text, indented.
std::string part(const std::string& head, const std::string& text) {
  std::string out = head + ":\n  ";
  for (const char c : text) {
    out += c;
    if (c == '\n') out += "  ";
  }
  return out;
}

struct Entry {
  const char* command;
  const char* example;  ///< one command a line; each is accepted as it stands
  const char* method;   ///< and where it is published; empty: nothing of that kind
};

constexpr std::array kEntries{
    Entry{"build",
          "beatlas build exam/ -o heart.beatlas --study exam.study\n"
          "beatlas build --study exam.study -o small.beatlas --scene palpation",
          "Nakao et al., Haptic reproduction and interactive visualization of a beating heart "
          "based on\ncardiac morphology, MEDINFO 2001; the help of each stage names what it does "
          "otherwise"},
    Entry{"import",
          "beatlas import exam/ --study exam.study\n"
          "beatlas import --surfaces ventricle.json --study v.study",
          "Order and times of frames: DICOM PS3.3, C.7.6.16 to C.8.13. Shifts of breath-holds: "
          "least squares,\nLucas and Kanade, IJCAI 1981. Key surfaces: Tokuyasu et al., FIMH 2003"},
    Entry{"segment", "beatlas segment --study exam.study --seeds marks.mrk.json --seeds-phase 7",
          "Seeded region growing, Adams and Bischof, IEEE PAMI 16, 1994, as a shortest-path forest "
          "through\nspace and time, Falcao et al., IEEE PAMI 26, 2004; smoothed before by Perona "
          "and Malik, IEEE\nPAMI 12, 1990; shading as Sled et al., IEEE TMI 17, 1998. The method "
          "threshold: Nakao et al.,\nMEDINFO 2001"},
    Entry{"register", "beatlas register --study exam.study",
          "The workspace of Nakao et al., MEDINFO 2001: 256 x 256 x 64 voxels of 1 x 1 x 3 mm"},
    Entry{"field", "beatlas field --study exam.study",
          "Narrow-band signed distance on sparse grids: Museth, ACM TOG 32, 2013; handles\n"
          "closed at simple points, Bertrand, Pattern Recognition Letters 15, 1994"},
    Entry{
        "mesh", "beatlas mesh --study exam.study",
        "Isotropic remeshing, Botsch and Kobbelt, SGP 2004. Segments of the LV: Cerqueira et al.,\n"
        "Circulation 105, 2002"},
    Entry{"pack", "beatlas pack --study exam.study -o heart.beatlas --scene full",
          "Distances beyond the band: fast sweeping, Zhao, Math. Comp. 74, 2005. Images: wavelet "
          "shrinkage,\nDonoho and Johnstone, Biometrika 81, 1994. The format: "
          "docs/package_format.md"},
    Entry{"phantom",
          "beatlas phantom -o p --preset small --without all\n"
          "beatlas phantom -o d --draw 12345 --format nifti",
          "Shares of voxels: Scardovelli and Zaleski, J. Comput. Phys. 164, 2000; noise: Rician, "
          "Gudbjartsson and\nPatz, Magn. Reson. Med. 34, 1995, drawn by Salmon et al., SC 2011. "
          "The preset adult has the\nnumbers of Nakao et al., MEDINFO 2001"},
    Entry{"info", "beatlas info heart.beatlas --json", ""},
    Entry{"validate",
          "beatlas validate heart.beatlas --truth p\n"
          "beatlas validate heart.beatlas --truth p --limits adult --max-force-mean-n 0.1",
          "Overlap: Dice, Ecology 26, 1945; the force compared is that of Nakao et al., MEDINFO "
          "2001, K x depth\nalong the normal"},
    Entry{"bench", "beatlas bench -o bench --quick --only voxel,published",
          "Beside our own the method of Nakao et al., MEDINFO 2001: nearest voxel, force linear "
          "between frames"},
    Entry{"export", "beatlas export heart.beatlas --to glb -o out",
          "glTF 2.0 (Khronos), NIfTI-1 (NIMH), OpenVDB: Museth, ACM TOG 32, 2013"},
    Entry{
        "report",
        "beatlas report exam.study\n"
        "beatlas report exam.study -o exam.html --json",
        "Normal ranges: Petersen et al., JCMR 19, 2017; Hudsmith et al., JCMR 7, 2005;\n"
        "Kawel-Boehm et al., JCMR 17, 2015; how far readers lie apart: Bai et al., JCMR 20, 2018"},
    Entry{"assess", "beatlas assess exam.study",
          "Shapes between slices: Raya and Udupa, IEEE TMI 9, 1990; slices left out to test what "
          "lies\nbetween them: Grevera and Udupa, IEEE TMI 17, 1998"},
    Entry{"status", "beatlas status exam.study", ""},
    Entry{"seeds",
          "beatlas seeds exam.study list\n"
          "beatlas seeds exam.study add --label lv_blood --lps 12.5,-30,4 --phase 7\n"
          "beatlas seeds exam.study add --label background --slice 9 --row 120 --column 44\n"
          "beatlas seeds exam.study remove 2",
          "Seeded region growing: Adams and Bischof, IEEE PAMI 16, 1994"},
    Entry{"identify", "beatlas identify samples/relaxation_middle.csv samples/press_middle.csv",
          "Least squares by equation (4) of Tokuyasu et al., Development of a training system for "
          "cardiac\nmuscle palpation, FIMH 2003"},
    Entry{
        "elastogram",
        "beatlas elastogram heart.beatlas stiffness.nii.gz -o stiffness.csv --unit pa --modulus "
        "shear",
        "Stiffness of myocardium by magnetic resonance: Kolipaka et al., Magn Reson Med 62, 2009"},
    Entry{"defaults", "beatlas defaults\nbeatlas defaults --recipe samples/recipe.json --json", ""},
};

}  // namespace

void complete_help(CLI::App& app) {
  for (CLI::App* command : app.get_subcommands({})) {
    const auto entry = std::find_if(kEntries.begin(), kEntries.end(), [&](const Entry& candidate) {
      return command->get_name() == candidate.command;
    });
    if (entry == kEntries.end()) continue;
    std::string footer = command->get_footer();
    const auto add = [&](const std::string& head, const std::string& text) {
      if (text.empty()) return;
      if (!footer.empty()) footer += "\n\n";
      footer += part(head, text);
    };
    add("Example", entry->example);
    add("Method", entry->method);
    command->footer(footer);
    command->formatter(std::make_shared<Formatter>());
  }
}

}  // namespace beatlas::cli
