// SPDX-License-Identifier: Apache-2.0
// Light path expressions: the automaton accepts what a matcher of another make does, on all paths
// of up to six events; what cannot be read is named with its column; limits are kept.
#include "hdStream/base/error.h"
#include "hdStream/film/aov.h"
#include "hdStream/film/lightPaths.h"

#include <gtest/gtest.h>

#include <functional>
#include <regex>
#include <string>
#include <vector>

namespace hds::test {
namespace {

/// The events of these tests, each as one letter that std::regex takes for itself.
struct Event {
    char letter;
    std::string type;  ///< letters of LPEs that stand for its type
    char scattering;   ///< or '-'
    std::string group; ///< of lights
};

const std::vector<Event> kEvents = {
    {'a', "C", '-', ""},     {'b', "R", 'D', ""},     {'c', "R", 'G', ""},
    {'d', "R", 'S', ""},     {'e', "T", 'D', ""},     {'f', "T", 'G', ""},
    {'g', "T", 'S', ""},     {'h', "V", '-', ""},     {'i', "L", '-', "key"},
    {'j', "LB", '-', "key"}, {'k', "L", '-', "fill"}, {'l', "LB", '-', "default"},
    {'m', "O", '-', ""}};

std::string Class(const std::function<bool(const Event&)>& matches) {
    std::string letters = "["; // an empty class matches nothing
    for (const Event& event : kEvents) {
        letters += matches(event) ? std::string(1, event.letter) : std::string();
    }
    return letters + "]";
}

/// The letters of a set or one letter, '.' or a set of them, at `at`; \return letters, negated.
std::pair<std::string, bool> Letters(const std::string& text, std::size_t* at) {
    if (text[*at] != '[') {
        return {std::string(1, text[(*at)++]), false};
    }
    const std::size_t end = text.find(']', *at);
    const std::string inside = text.substr(*at + 1, end - *at - 1);
    *at = end + 1;
    return inside[0] == '^' ? std::pair(inside.substr(1), true) : std::pair(inside, false);
}

bool Has(const std::pair<std::string, bool>& letters, const std::string& own) {
    bool isIn = letters.first == ".";
    for (const char letter : letters.first) {
        isIn = isIn || own.find(letter) != std::string::npos;
    }
    return isIn != letters.second;
}

/// An expression, of those below, as a regular expression over the letters of events.
std::string Translate(const std::string& text) {
    std::string regex;
    for (std::size_t at = 0; at < text.size();) {
        const char letter = text[at];
        if (letter == '<') {
            ++at;
            const auto type = Letters(text, &at);
            std::pair<std::string, bool> scattering(".", false);
            std::string group;
            if (text[at] != '>' && text[at] != '\'') {
                scattering = Letters(text, &at);
            }
            if (text[at] == '\'') {
                const std::size_t end = text.find('\'', at + 1);
                group = text.substr(at + 1, end - at - 1);
                at = end + 1;
            }
            ++at;
            regex += Class([&](const Event& event) {
                return Has(type, event.type) && Has(scattering, std::string(1, event.scattering)) &&
                       (group.empty() || event.group == group);
            });
        } else if (letter == '[' || letter == '.' || std::isalpha(letter) != 0) {
            const auto letters = Letters(text, &at);
            regex += Class(
                [&](const Event& event) { return Has(letters, event.type + event.scattering); });
        } else {
            regex += letter;
            ++at;
        }
    }
    return regex;
}

const std::vector<std::string> kExpressions = {"C.*[LO]",
                                               "C<RD>.*[LO]",
                                               "C<R[GS]>.*L",
                                               "CT.*[LO]",
                                               "C.[LO]",
                                               "C..+[LO]",
                                               "C.*<L.'key'>",
                                               "C.*B",
                                               "C<.D>*O",
                                               "C(D|<TS>)+L",
                                               "C[^D]*[LO]",
                                               "C<[RT][^S]>{1,2}O",
                                               "CD{2}L",
                                               "CS{1,}D?[^O]",
                                               "C(<RD><TS>){1,2}[LO]",
                                               "C<[^T]D>L",
                                               "C(S|G)*D.*O|CL",
                                               "C.*D.{0,1}L",
                                               "C.*<L.'default'>",
                                               "C.*<[LO]'fill'>|C<T.>B",
                                               "[RTLO]*",
                                               "V*CL",
                                               "C[DV]+V.*[LO]",
                                               "C(.*D.*){2}L",
                                               "C<RG>|C",
                                               ".*"};

/// The number of the event in LightPathState::next, for 'b' to 'h'.
std::uint32_t ScatteringOf(char letter) {
    return static_cast<std::uint32_t>(letter - 'b');
}

std::uint32_t Matches(const LightPathAutomaton& automaton, const std::string& word) {
    std::uint32_t state = 0;
    for (std::size_t i = 1; i + 1 < word.size(); ++i) {
        state = automaton.states[state].next[ScatteringOf(word[i])];
    }
    const Event& end = kEvents[static_cast<std::size_t>(word.back() - 'a')];
    return automaton.states[state]
        .accepts[end.type == "O" ? automaton.EndOfObject()
                                 : automaton.EndOfLight(end.group, end.type == "LB")];
}

/// All paths: the camera, up to `most` scatterings, what emits.
void ForEachWord(std::uint32_t most, const std::string& begin,
                 const std::function<void(const std::string&)>& visit) {
    for (char end = 'i'; end <= 'm'; ++end) {
        visit(begin + end);
    }
    for (char scattering = 'b'; most > 0 && scattering <= 'h'; ++scattering) {
        ForEachWord(most - 1, begin + scattering, visit);
    }
}

TEST(LightPaths, AcceptsWhatAMatcherOfAnotherMakeDoes) {
    const LightPathAutomaton automaton = CompileLightPaths(kExpressions);
    std::vector<std::regex> regexes;
    for (const std::string& expression : kExpressions) {
        regexes.emplace_back(Translate(expression));
    }
    std::size_t numWords = 0;
    std::vector<std::size_t> numMatches(kExpressions.size());
    ForEachWord(4, "a", [&](const std::string& word) {
        const std::uint32_t matches = Matches(automaton, word);
        ++numWords;
        for (std::size_t i = 0; i < kExpressions.size(); ++i) {
            const bool isMatch = std::regex_match(word, regexes[i]);
            numMatches[i] += isMatch ? 1 : 0;
            ASSERT_EQ((matches >> i & 1U) != 0, isMatch) << kExpressions[i] << " of " << word;
        }
    });
    EXPECT_EQ(numWords, 14005U);
    for (std::size_t i = 0; i < kExpressions.size(); ++i) {
        const bool isNever = kExpressions[i] == "[RTLO]*" || kExpressions[i] == "C<RG>|C";
        EXPECT_EQ(numMatches[i] == 0, isNever) << kExpressions[i];
    }
}

TEST(LightPaths, EachAloneIsAsAllTogether) {
    const LightPathAutomaton all = CompileLightPaths(kExpressions);
    for (std::size_t i = 0; i < kExpressions.size(); ++i) {
        const LightPathAutomaton one = CompileLightPaths({kExpressions[i]});
        EXPECT_LE(one.states.size(), all.states.size());
        ForEachWord(3, "a", [&](const std::string& word) {
            EXPECT_EQ(Matches(one, word), Matches(all, word) >> i & 1U) << word;
        });
    }
}

TEST(LightPaths, StatesThatCannotBeToldApartAreOne) {
    EXPECT_EQ(CompileLightPaths({"C.*[LO]"}).states.size(), 1U);
    EXPECT_EQ(CompileLightPaths({"C.*[LO]|C.*.*[LO]"}).states.size(), 1U);
    EXPECT_EQ(CompileLightPaths({"C<RD>.*L"}).states.size(), 3U); // camera, after RD, never
    EXPECT_EQ(CompileLightPaths({"C<RD>.*L", "C<RG>.*L"}).states.size(), 4U);
}

TEST(LightPaths, EqualExpressionsGiveEqualAutomata) {
    const LightPathAutomaton a = CompileLightPaths({"C.*<L.'b'>", "C.*<L.'a'>"});
    EXPECT_EQ(a.labels, (std::vector<std::string>{"a", "b"}));
    EXPECT_EQ(a.EndOfLight("", false), 0U) << "no expression tells it apart";
    EXPECT_EQ(a.EndOfLight("b", true), 5U);
}

struct Bad {
    std::string expression;
    std::size_t column;
    std::string what;
};

void PrintTo(const Bad& bad, std::ostream* out) {
    *out << bad.expression;
}

class BadLightPath : public testing::TestWithParam<Bad> {};

TEST_P(BadLightPath, IsNamedWithItsColumn) {
    const Bad& bad = GetParam();
    try {
        CompileLightPaths({"C.*L", bad.expression});
        FAIL() << "it was read";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::Usage);
        const std::string begin = "light path expression '" + bad.expression + "', column " +
                                  std::to_string(bad.column) + ": ";
        EXPECT_EQ(std::string(error.what()), begin + bad.what);
    }
}

INSTANTIATE_TEST_SUITE_P(
    LightPaths, BadLightPath,
    testing::Values(Bad{"", 1, "there is no event"}, Bad{"C(D", 4, "')' of a group is missing"},
                    Bad{"CD)L", 3, "')' without '('"}, Bad{"CX", 2, "'X' is no event"},
                    Bad{"C[LO", 5, "']' of a set is missing"}, Bad{"C[]L", 3, "the set is empty"},
                    Bad{"C<RD", 5, "'>' of an event is missing"},
                    Bad{"C<RX>L", 4, "'X' is no scattering (D G S s)"},
                    Bad{"C<DR>L", 3, "'D' is no type of event (C R T V L O B)"},
                    Bad{"C.*<L.'key>", 8, "the label has no second quote"},
                    Bad{"C.*<L.''>", 8, "the label is empty"},
                    Bad{"CD{2,1}L", 7, "the second count is below the first"},
                    Bad{"CD{}L", 4, "a count is missing"}, Bad{"CD{100}L", 6, "counts go up to 99"},
                    Bad{"C|", 3, "there is no event"}, Bad{"*", 1, "'*' is no event"}));

TEST(LightPaths, LimitsAreNamed) {
    const auto fail = [](const std::vector<std::string>& expressions) {
        try {
            CompileLightPaths(expressions);
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_EQ(fail(std::vector<std::string>(33, "C.*L")),
              "light path expressions: there are 33, a render can have 32");
    EXPECT_NE(fail({"C((D{99}){99}){99}L"}).find("its counts multiply"), std::string::npos);
    EXPECT_NE(fail({"C.*D.{12}L"}).find("more than 1024 states"), std::string::npos);
    EXPECT_EQ(fail({"C.*D.{7}L"}), "");
    // As deep as they are long they would take the stack.
    const std::string many(400000, '*');
    EXPECT_NE(fail({"CD" + many + "L"}).find("too many repeats of one event"), std::string::npos);
    EXPECT_EQ(fail({"CD" + many.substr(0, 100) + "L"}), "");
    EXPECT_EQ(fail({"C[" + std::string(400000, 'D') + "]*L"}), "");
    std::vector<std::string> labels(1, "C");
    for (int i = 0; i < 200; ++i) {
        labels[0] += "<L.'" + std::to_string(i) + "'>";
    }
    EXPECT_NE(fail(labels).find("200 groups of lights"), std::string::npos);
}

TEST(LightPaths, AovsOfOneExpressionShareIt) {
    const AovLayout layout =
        MakeAovLayout({"color", "diffuse", "lpe:C<RD>.*[LO]", "lightGroup:key", "alpha"});
    EXPECT_EQ(layout.lightPaths, (std::vector<std::string>{"C<RD>.*[LO]", "C.*<L.'key'>"}));
    EXPECT_EQ(layout.Find("lpe:C<RD>.*[LO]")->lightPath, layout.Find("diffuse")->lightPath);
    EXPECT_EQ(layout.Find("lightGroup:key")->lightPath, 1U);
    EXPECT_EQ(layout.floatsPerPixel, 14U);
    EXPECT_THROW(CheckAovs({"color", "lpe:C("}), Error);
    EXPECT_THROW(CheckAovs({"lightGroup:a'b"}), Error);
    EXPECT_NO_THROW(CheckAovs({"lightGroup:key", "lpe:C.*O"}));
}

TEST(LightPaths, AllPresetsCanBeRead) {
    std::size_t count = 0;
    for (const AovInfo& info : AovTable()) {
        if (!info.lightPaths.empty()) {
            EXPECT_NO_THROW(CheckAovs({info.name})) << info.name;
            EXPECT_TRUE(IsSummed(info.name));
            ++count;
        }
    }
    EXPECT_EQ(count, 13U);
}

} // namespace
} // namespace hds::test
