#include "pipeline/prior/model.h"

#include <algorithm>
#include <fstream>
#include <span>

#include <gtest/gtest.h>

#include "pipeline/core/words.h"
#include "pipeline/prior/graph_ends.h"
#include "pipeline/prior/network.h"
#include "pipeline/prior/prior.h"
#include "runtime/base/error.h"
#include "tests/json_file.h"
#include "tests/unit/prior/made_models.h"

namespace beatlas::prior {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

std::string refusal_of(const fs::path& onnx) {
  return made::refusal([&] { (void)Model::load(onnx); });
}

TEST(PriorModel, TellsWhatItsJsonSays) {
  const Model model = Model::load(made::model_file("pixelwise"));
  EXPECT_EQ(model.card().pixel_mm, 2);
  EXPECT_EQ(model.card().multiple, 4);
  EXPECT_EQ(model.card().channels, (std::vector{Channel::Mean, Channel::Frame, Channel::Above,
                                                Channel::Deviation, Channel::Below}));
  EXPECT_EQ(model.card().outputs, (std::vector<std::uint8_t>{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(model.sha256().size(), 64U);
  EXPECT_EQ(model.card().card.at("made_by"), "tests/unit/prior/make_models.py");
}

TEST(PriorModel, AnOnnxFileTellsItsPlanes) {
  const Model model = Model::load(made::model_file("frame_alone"));
  const GraphEnds ends = graph_ends(model.onnx());
  ASSERT_EQ(ends.inputs.size(), 1U);
  ASSERT_EQ(ends.outputs.size(), 1U);
  EXPECT_EQ(ends.inputs[0], (std::vector<long long>{0, 1, 0, 0}));
  ASSERT_EQ(ends.outputs[0].size(), 4U);
  EXPECT_EQ(ends.outputs[0][1], 4);
}

TEST(PriorModel, MissingFilesAreNamed) {
  const made::Folder folder;
  EXPECT_TRUE(made::tells(refusal_of(folder.path() / "none.onnx"), "none.onnx: there is no such"));
  const fs::path lonely = folder.copy_of("frame_alone");
  fs::remove(card_path(lonely));
  EXPECT_TRUE(
      made::tells(refusal_of(lonely), "its description frame_alone.json: there is no such file"));
  EXPECT_TRUE(made::tells(refusal_of(folder.path()), "there is no such file"));
  const fs::path whole = folder.copy_of("unet");
  EXPECT_TRUE(made::tells(refusal_of(card_path(whole)), "name the .onnx file beside it"));
}

TEST(PriorModel, AFileThatWasCutOrIsNoneIsRefused) {
  const made::Folder folder;
  const auto changed = [&](const std::function<void(std::string&)>& change) {
    return refusal_of(folder.copy_of("unet", change));
  };
  EXPECT_TRUE(made::tells(changed([](std::string& onnx) { onnx.resize(onnx.size() / 2); }),
                          "one that is cut"));
  EXPECT_TRUE(made::tells(changed([](std::string& onnx) { onnx.clear(); }), "no ONNX file"));
  EXPECT_TRUE(made::tells(changed([](std::string& onnx) { onnx = "hello"; }), "no ONNX file"));
  EXPECT_TRUE(made::tells(changed([](std::string& onnx) { onnx = std::string(300, '\xff'); }),
                          "no ONNX file"));
}

TEST(PriorModel, NoCutOfAFilePasses) {
  std::string whole;
  const made::Folder folder;
  (void)folder.copy_of("frame_alone", [&](std::string& onnx) { whole = onnx; });
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::string cut = whole.substr(0, size);
    try {  // a cut between two fields is no sound model, but a sound message
      (void)graph_ends(std::as_bytes(std::span(cut)));
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    }
  }
}

TEST(PriorModel, FilesThatDoNotBelongTogetherAreRefused) {
  const made::Folder folder;
  const fs::path onnx =
      folder.copy_of("unet", {}, [](json& card) { card["sha256"] = std::string(64, '0'); });
  EXPECT_TRUE(made::tells(refusal_of(onnx), "do not belong together"));
}

TEST(PriorModel, ItsJsonIsReadStrictly) {
  const made::Folder folder;
  const auto changed = [&](const std::function<void(json&)>& change) {
    return refusal_of(folder.copy_of("unet", {}, change));
  };
  EXPECT_TRUE(made::tells(changed([](json& card) { card["pixel"] = 2; }),
                          "unet.json: /pixel is not a known key; did you mean pixel_mm?"));
  EXPECT_TRUE(
      made::tells(changed([](json& card) { card.erase("channels"); }), "/channels is missing"));
  EXPECT_TRUE(made::tells(changed([](json& card) { card["format"] = 2; }), "/format is 2"));
  EXPECT_TRUE(made::tells(changed([](json& card) { card["pixel_mm"] = 0; }),
                          "/pixel_mm must be a number from 0.5 to 10"));
  EXPECT_TRUE(made::tells(changed([](json& card) { card["multiple"] = 1.5; }), "/multiple"));
  EXPECT_TRUE(made::tells(changed([](json& card) { card["channels"][1] = "beneath"; }),
                          "/channels/1 must be one of frame, below, above, mean, deviation"));
  EXPECT_TRUE(made::tells(changed([](json& card) { card["channels"] = json::array(); }),
                          "/channels must be a list"));
  EXPECT_TRUE(made::tells(changed([](json& card) { card["channels"][1] = "frame"; }),
                          "/channels/1 stands there twice"));
  for (const json& wrong : {json(40), json{40}, json{40, 30}, json{-1, 30}, json{40, "x"}}) {
    EXPECT_TRUE(made::tells(changed([&](json& card) { card["lv_ml"] = wrong; }),
                            "/lv_ml must be two ascending numbers"));
  }
  EXPECT_TRUE(made::tells(changed([](json& card) { card["outputs"][3] = "spleen"; }),
                          "/outputs/3 must be one of background"));
  EXPECT_TRUE(made::tells(changed([](json& card) { card["outputs"].erase(3); }),
                          "/outputs lacks lv_blood"));
  EXPECT_TRUE(
      made::tells(changed([](json& card) { card["card"]["x"] = json::array(); }), "/card/x"));
  for (const json& tones :
       {json(0.5), json::array(), json({0.5, 0.1}), json({2.1}), json({"root"})}) {
    EXPECT_TRUE(made::tells(changed([&](json& card) { card["tones"] = tones; }), "/tones"))
        << tones;
  }
  EXPECT_TRUE(made::tells(changed([](json& card) { card = json::array(); }), "JSON object"));
  const fs::path onnx = folder.copy_of("unet");
  std::ofstream(card_path(onnx)) << R"({"format": 1, "pixel_m)";
  EXPECT_TRUE(made::tells(refusal_of(onnx), "unet.json: it is no JSON"));
}

TEST(PriorModel, ItsSchemaNamesTheSameKeysAndWords) {
  const json schema = test::json_file(BEATLAS_PRIOR_SCHEMA);
  const json& keys = schema.at("properties");
  for (const json& word : keys.at("channels").at("items").at("enum")) {
    const made::Folder folder;
    (void)Model::load(folder.copy_of("frame_alone", {},
                                     [&](json& card) { card["channels"] = json::array({word}); }));
  }
  const json& words = keys.at("outputs").at("items").at("enum");
  ASSERT_EQ(words.size(), kLabelWords.size());
  for (std::size_t at = 0; at < words.size(); ++at) EXPECT_EQ(words[at], kLabelWords[at]);
  json card = test::json_file(card_path(made::model_file("unet")));
  card["orientations"] = 2;   // models without it are of one orientation
  card["lv_ml"] = {40, 400};  // show hearts as they are
  card["tones"] = {0.5, 1};   // and the root of brightness
  EXPECT_EQ(card.size(), keys.size());
  for (const auto& key : keys.items()) {
    ASSERT_TRUE(card.contains(key.key()));
    json without = card;
    without.erase(key.key());
    const json& required = schema.at("required");
    if (std::find(required.begin(), required.end(), key.key()) == required.end()) {
      EXPECT_NO_THROW((void)model_card_from_json(without));
    } else {
      EXPECT_TRUE(made::tells(made::refusal([&] { (void)model_card_from_json(without); }),
                              "/" + key.key() + " is missing"));
    }
    for (const char* end : {"minimum", "maximum"}) {
      if (!key.value().contains(end)) continue;
      json at_end = card;
      at_end[key.key()] = key.value().at(end);
      EXPECT_NO_THROW((void)model_card_from_json(at_end)) << key.key();
      at_end[key.key()] = key.value().at(end).get<double>() + (end[1] == 'i' ? -1 : 1);
      EXPECT_TRUE(
          made::tells(made::refusal([&] { (void)model_card_from_json(at_end); }), "/" + key.key()));
    }
  }
}

// OpenCV would take a convolution of one channel for one in groups.
TEST(PriorModel, AnotherNumberOfPlanesIsRefused) {
  const made::Folder folder;
  const fs::path more = folder.copy_of("frame_alone", {}, [](json& card) {
    card["channels"] = {"frame", "mean"};
  });
  EXPECT_TRUE(made::tells(refusal_of(more), "input has 1 plane, and its JSON names 2 channels"));
  const fs::path outputs =
      folder.copy_of("frame_alone", {}, [](json& card) { card["outputs"].push_back("aorta"); });
  EXPECT_TRUE(
      made::tells(refusal_of(outputs), "output has 4 planes, and its JSON names 5 outputs"));
}

TEST(PriorModel, WhatANetworkGivesIsCountedWhenItRuns) {
  const Model model = Model::load(made::model_file("frame_alone"));
  ModelCard card = model.card();
  card.outputs.push_back(kLabelAorta);
  const std::vector<float> image(16);
  EXPECT_TRUE(
      made::tells(made::refusal([&] { (void)Network(model.onnx(), card).run(image, 4, 4); }),
                  "gives 1 x 4 x 4 x 4 for an input of 1 x 1 x 4 x 4"));
}

TEST(PriorModel, ALayerThatOpencvRefusesIsToldInOneLine) {
  const made::Folder folder;
  const fs::path onnx = folder.copy_of("frame_alone", [](std::string& bytes) {
    const std::string type = "\4Conv";  // its length before it, as no name has
    bytes.replace(bytes.find(type), type.size(), "\4Conx");
  });
  const std::string said = refusal_of(onnx);
  EXPECT_TRUE(made::tells(said, "OpenCV's dnn cannot read it for its layer Conx;"));
  EXPECT_EQ(said.find(".cpp"), std::string::npos) << said;
}

TEST(PriorModel, ANetworkForAnotherMultipleIsRefused) {
  const made::Folder folder;  // one level halves: an odd side does not come back
  const fs::path onnx = folder.copy_of("unet", {}, [](json& card) { card["multiple"] = 1; });
  const std::string said = refusal_of(onnx);
  EXPECT_TRUE(made::tells(said, "unet.onnx: "));
  EXPECT_EQ(said.find(".cpp"), std::string::npos) << said;
}

TEST(PriorModel, TheBuiltInOneIsThereOrItsAbsenceIsTold) {
  try {
    const fs::path ours = default_model_path();
    EXPECT_EQ(Model::load(ours).sha256().size(), 64U);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    EXPECT_TRUE(made::tells(error.what(), "share/beatlas/heart_prior.onnx"));
    EXPECT_TRUE(made::tells(error.what(), "--prior none"));
  }
}

}  // namespace
}  // namespace beatlas::prior
