"use strict";
// A plan on a graph (drawn by prefplan): the current state, and the arrows already taken.

const GRAPH = "The coloured state is the current one. Thick arrows are the plan's actions, numbered in order; each arrow has its action and its cost.";

class PlanGraph {
  constructor(plan) {
    this.plan = plan;
    const picture = document.getElementById(`map-${plan.index}`).content.cloneNode(true), svg = picture.querySelector("svg");
    svg.style.setProperty("--natural", `${svg.getAttribute("width")}px`);
    svg.style.setProperty("--aspect", svg.getAttribute("width") / svg.getAttribute("height"));
    this.words = plan.graph.note ? `${plan.graph.note} ${GRAPH}` : GRAPH;
    this.element = scrollBox(plan.graph.words, "automaton graph picture", picture);
  }

  show(time) {
    const node = this.plan.graph.at[progress(this.plan, time).done];
    if (node === this.node) return;
    this.node = node;
    for (const part of this.element.querySelectorAll(".here")) part.classList.remove("here");
    for (const part of this.element.querySelectorAll(`.s${node}`)) part.classList.add("here");
    bringIntoView(this.element, this.element.querySelector(".node.here"));
  }
}
