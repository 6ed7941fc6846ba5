#pragma once
/// The stages as `beatlas bench` calls them: values pass in memory, and a stage runs again only if
/// an option that it obeys, or that one before it obeys, is another.

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assess/bench_report.h"
#include "pipeline/assess/truth_set.h"
#include "pipeline/build/recipe.h"
#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/phantom/phantom.h"
#include "runtime/atlas/atlas.h"

namespace beatlas::cli {

/// A value with what it cost to make it.
template <class T>
struct Timed {
  std::shared_ptr<const T> value;
  double wall_s = 0;
  std::optional<double> memory_mb;
  bool shared = false;  ///< other runs will ask for it again
};

class BenchRunner {
 public:
  /// @param work an empty folder for packages
  BenchRunner(phantom::PhantomSpec spec, nlohmann::json defaults, int repeats,
              std::filesystem::path work);

  /// All options of all stages, with the sections "phantom" {"matrix", "phases"}, "level"
  /// {"edge_mm"}, of the surfaces that are packed, and "query" {"space", "time"}.
  [[nodiscard]] static nlohmann::json default_settings(const phantom::PhantomSpec& spec);

  /// Every figure is from a file that was written and opened again.
  /// @throws Error{Machine} if stopped, or a package cannot be written
  [[nodiscard]] assess::BenchRow measure(const assess::BenchRun& run, StageContext& context);

  /// A whole build of the phantom with these settings, from nothing, for the scene palpation.
  [[nodiscard]] assess::ScalingRow build_all(const nlohmann::json& settings, StageContext& context);

 private:
  struct Imaging {
    std::shared_ptr<const phantom::Phantom> phantom;
    Exam exam;
    std::shared_ptr<const LabelCycle> truth;
  };
  struct Shapes {
    Affine workspace_from_lps = Affine::Identity();
    std::map<Structure, ShapeCycle> cycles;
  };
  /// A package on disk and what it cost.
  struct Package {
    std::filesystem::path file;
    std::size_t bytes = 0;
    double wall_s = 0;
    std::optional<double> memory_mb;
  };
  struct Costs {
    std::map<std::string, double> stage_s;
    std::map<std::string, std::optional<double>> memory_mb;
    template <class T>
    void add(const std::string& stage, const T& made) {
      stage_s[stage] = made.wall_s;
      memory_mb[stage] = made.memory_mb;
    }
  };

  const assess::TruthSet& truth(StageContext& context);
  Timed<Imaging> imaging(const nlohmann::json& settings, StageContext& context);
  Timed<Segmentation> segmentation(const nlohmann::json& settings, StageContext& context);
  Timed<Shapes> shapes(const nlohmann::json& settings, assess::Sweep sweep, StageContext& context);
  Timed<FieldCycle> field(const nlohmann::json& settings, assess::Sweep sweep, Structure structure,
                          StageContext& context);
  Timed<SurfaceCycle> surface(const nlohmann::json& settings, assess::Sweep sweep,
                              Structure structure, StageContext& context);
  Package pack_fields(const nlohmann::json& settings, assess::Sweep sweep,
                      const std::vector<Structure>& structures, StageContext& context);
  Package pack_surfaces(const nlohmann::json& settings, const std::vector<SurfaceCycle>& surfaces,
                        double edge_mm, assess::Sweep sweep, StageContext& context);
  [[nodiscard]] atlas::Manifest manifest(const Imaging& imaging, const Shapes& shapes,
                                         const std::string& scene) const;

  void measure_field(assess::BenchRow& row, StageContext& context);
  void measure_surface(assess::BenchRow& row, StageContext& context);
  void measure_volume(assess::BenchRow& row, StageContext& context);
  void measure_published(assess::BenchRow& row, StageContext& context);
  /// Costs of all stages of a run -> its times and memory.
  void take_costs(assess::BenchRow& row, const Costs& costs) const;

  /// Looks a value up by what it depends on, or makes it. It is kept until forget(), or to the end
  /// if it is shared: if everything it depends on is as in the defaults.
  template <class T, class Make>
  Timed<T> memo(std::map<std::string, Timed<T>>& kept, const std::string& key, bool shared,
                const Make& make);
  void forget();
  /// Whether the stages up to `stage` obey the defaults.
  [[nodiscard]] bool is_default(const nlohmann::json& settings, const std::string& stage) const;

  phantom::PhantomSpec spec_;
  nlohmann::json defaults_;
  int repeats_;
  std::filesystem::path work_;
  std::optional<assess::TruthSet> truth_;
  std::map<std::string, Timed<Imaging>> imagings_;
  std::map<std::string, Timed<Segmentation>> segmentations_;
  std::map<std::string, Timed<Shapes>> shapes_;
  std::map<std::string, Timed<FieldCycle>> fields_;
  std::map<std::string, Timed<SurfaceCycle>> surfaces_;
  std::map<std::string, Package> packages_;
  std::map<std::string, Costs> costs_;  ///< of what stands in packages_
  std::map<std::string, assess::BenchRow> rows_;
};

}  // namespace beatlas::cli
