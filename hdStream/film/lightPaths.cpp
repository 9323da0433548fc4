// SPDX-License-Identifier: Apache-2.0
// Sources: Thompson 1968, "Regular Expression Search Algorithm" (the nondeterministic automata);
// Rabin and Scott 1959, "Finite Automata and Their Decision Problems" (sets of states); Moore 1956,
// "Gedanken-experiments on Sequential Machines" (states that cannot be told apart).
#include "hdStream/film/lightPaths.h"

#include "hdStream/base/error.h"
#include "hdStream/film/lightPathParser.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

namespace hds {

namespace {

constexpr std::size_t kMaxSets = 8192; ///< of states, before those that are alike become one

/// A state of all expressions at once: nodes of their machines, one numbering for all.
using NodeSet = std::vector<std::uint32_t>;

[[noreturn]] void FailStates() {
    throw Error("light path expressions: together they need more than " +
                    std::to_string(kMaxLightPathStates) +
                    " states; ask for fewer, or for shorter counts",
                ErrorKind::Usage);
}

/// The camera, the scatterings, and what emits: in the order of LightPathAutomaton's ends.
std::vector<LightEvent> MakeEvents(const std::vector<std::string>& labels) {
    std::vector<LightEvent> events{{}};
    for (const char* scattering : kScatterings) {
        events.push_back({scattering[0], scattering[1], false, ""});
    }
    for (std::size_t i = 0; i <= labels.size(); ++i) {
        for (const bool isDome : {false, true}) {
            events.push_back({'L', '.', isDome, i == 0 ? std::string() : labels[i - 1]});
        }
    }
    events.push_back({'O', '.', false, ""});
    return events;
}

/// Runs the machines of all expressions side by side.
class Runner {
public:
    explicit Runner(const std::vector<LightPathMachine>& machines) {
        for (const LightPathMachine& machine : machines) {
            const auto base = static_cast<std::uint32_t>(_nodes.size());
            _starts.push_back(base + machine.start);
            _ends.push_back(base + machine.end);
            for (LightPathMachine::Node node : machine.nodes) {
                node.next += base;
                for (std::uint32_t& free : node.free) {
                    free += base;
                }
                _nodes.push_back(std::move(node));
            }
        }
    }

    NodeSet Start() const { return Close(_starts); }

    NodeSet After(const NodeSet& set, std::size_t event) const {
        NodeSet reached;
        for (const std::uint32_t node : set) {
            if (_nodes[node].events[event]) {
                reached.push_back(_nodes[node].next);
            }
        }
        return Close(reached);
    }

    /// A bit for each expression that ends in the set.
    std::uint32_t Matches(const NodeSet& set) const {
        std::uint32_t bits = 0;
        for (std::size_t i = 0; i < _ends.size(); ++i) {
            bits |= std::binary_search(set.begin(), set.end(), _ends[i]) ? 1U << i : 0U;
        }
        return bits;
    }

private:
    /// With all that is reached without an event, in order.
    NodeSet Close(const NodeSet& set) const {
        std::set<std::uint32_t> closed;
        NodeSet open = set;
        while (!open.empty()) {
            const std::uint32_t node = open.back();
            open.pop_back();
            if (closed.insert(node).second) {
                open.insert(open.end(), _nodes[node].free.begin(), _nodes[node].free.end());
            }
        }
        return {closed.begin(), closed.end()};
    }

    std::vector<LightPathMachine::Node> _nodes;
    std::vector<std::uint32_t> _starts;
    std::vector<std::uint32_t> _ends;
};

std::vector<LightPathState> MakeStates(const Runner& runner, std::uint32_t numEnds) {
    std::map<NodeSet, std::uint32_t> numbers;
    std::vector<NodeSet> sets;
    const auto numberOf = [&](NodeSet set) {
        const auto [place, isNew] =
            numbers.emplace(std::move(set), static_cast<std::uint32_t>(sets.size()));
        if (isNew) {
            sets.push_back(place->first);
        }
        return place->second;
    };
    numberOf(runner.After(runner.Start(), 0));
    std::vector<LightPathState> states;
    for (std::size_t i = 0; i < sets.size(); ++i) {
        if (sets.size() > kMaxSets) {
            FailStates();
        }
        const NodeSet set = sets[i];
        LightPathState state;
        for (std::size_t event = 0; event < kScatterings.size(); ++event) {
            state.next[event] = numberOf(runner.After(set, 1 + event));
        }
        for (std::uint32_t end = 0; end < numEnds; ++end) {
            state.accepts.push_back(
                runner.Matches(runner.After(set, 1 + kScatterings.size() + end)));
        }
        states.push_back(std::move(state));
    }
    return states;
}

/// States that no path can tell apart become one; the first stays the first.
std::vector<LightPathState> Merge(const std::vector<LightPathState>& states) {
    std::vector<std::uint32_t> classes(states.size(), 0);
    std::size_t numClasses = 1;
    while (true) {
        using Seen = std::tuple<std::uint32_t, decltype(LightPathState::next),
                                decltype(LightPathState::accepts)>;
        std::map<Seen, std::uint32_t> numbers;
        std::vector<std::uint32_t> refined;
        for (std::size_t i = 0; i < states.size(); ++i) {
            auto next = states[i].next;
            for (std::uint32_t& state : next) {
                state = classes[state];
            }
            refined.push_back(numbers
                                  .emplace(Seen(classes[i], next, states[i].accepts),
                                           static_cast<std::uint32_t>(numbers.size()))
                                  .first->second);
        }
        classes = std::move(refined);
        if (numbers.size() == numClasses) {
            break;
        }
        numClasses = numbers.size();
    }
    std::vector<LightPathState> merged(numClasses);
    for (std::size_t i = states.size(); i-- > 0;) {
        LightPathState& state = merged[classes[i]];
        state = states[i];
        for (std::uint32_t& next : state.next) {
            next = classes[next];
        }
    }
    return merged;
}

} // namespace

std::uint32_t LightPathAutomaton::EndOfLight(const std::string& group, bool isDome) const {
    const std::string& label = group.empty() ? kDefaultLightGroup : group;
    const auto found = std::find(labels.begin(), labels.end(), label);
    const auto number =
        found == labels.end() ? 0 : static_cast<std::uint32_t>(found - labels.begin()) + 1;
    return 2 * number + (isDome ? 1 : 0);
}

LightPathAutomaton CompileLightPaths(const std::vector<std::string>& expressions) {
    if (expressions.size() > kMaxLightPaths) {
        throw Error("light path expressions: there are " + std::to_string(expressions.size()) +
                        ", a render can have " + std::to_string(kMaxLightPaths),
                    ErrorKind::Usage);
    }
    std::set<std::string> labels;
    for (const std::string& expression : expressions) {
        for (std::string& label : LabelsOf(expression)) {
            labels.insert(std::move(label));
        }
    }
    LightPathAutomaton automaton;
    automaton.labels.assign(labels.begin(), labels.end());
    const std::vector<LightEvent> events = MakeEvents(automaton.labels);
    if (events.size() > kMaxLightEvents) {
        throw Error("light path expressions: they name " + std::to_string(labels.size()) +
                        " groups of lights, which is too many",
                    ErrorKind::Usage);
    }
    std::vector<LightPathMachine> machines;
    for (const std::string& expression : expressions) {
        machines.push_back(ParseLightPath(expression, events));
    }
    automaton.states = Merge(MakeStates(Runner(machines), automaton.NumEnds()));
    const std::size_t words = automaton.states.size() * (kScatterings.size() + automaton.NumEnds());
    if (automaton.states.size() > kMaxLightPathStates || words > kMaxLightPathWords) {
        FailStates();
    }
    return automaton;
}

} // namespace hds
