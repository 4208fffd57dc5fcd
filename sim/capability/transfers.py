"""Transfers of objects between locations, rehearsed among the objects that stand around at that moment."""

from contextlib import suppress
from dataclasses import replace

from prefplan.errors import ModelError
from prefplan.models.feasibility import Transfer
from sim.capability.arrangement import vacated
from sim.capability.attempts import MORE_ORIGINS, Attempt, Attempts, while_there
from sim.capability.place_check import Neighbours, PlaceCheck
from sim.capability.rehearsal import BROUGHT, TAKEN, bringing
from sim.capability.witness import Witness
from sim.world.places import under


class Transfers:
    """Finds which transfers the arm can carry out."""

    def __init__(self, attempts: Attempts) -> None:
        """Take the attempts, which run the rehearsals."""
        self._attempts, self._scene = attempts, attempts.scene
        # Transfers that succeeded, by object, locations, and what is below these.
        self._witnesses: dict[tuple[str, str, str, Neighbours], list[Witness]] = {}

    def rehearse(self, transfer: Transfer) -> PlaceCheck | None:
        """Return what the arm cannot do of a transfer; None if it can.

        If it is not known which objects hinder it, or in which slots of a location they are, it is excluded only while
        all other objects stand where they do.
        """
        obj, source, target, others = transfer
        witnesses = self._witnesses.setdefault((obj, source, target, self._carriers(transfer)), [])
        if any(witness.allows(dict(others)) for witness in witnesses):
            return None
        rehearsal = bringing(obj, source, target or source, dict(others)).beginning(BROUGHT if target else TAKEN)
        try:
            attempt = self._attempts.attempt(rehearsal)
        except ModelError:  # a user's own operators may allow such places
            return None
        if attempt.error is None:
            cell = self._attempts.cell
            witnesses.append(Witness(self._scene, dict(others), cell.followed, cell.levers))
            return None
        if attempt.done < TAKEN and target:
            taken = self._attempts.attempt(replace(rehearsal.beginning(TAKEN), location=source))
            # A tilted hand comes in a pose that suits the target: in another pose, it may reach the object.
            same = taken.error is not None and (taken.done or taken.for_good)
            attempt = taken if same else replace(attempt, done=TAKEN)
        return self._refused(transfer, attempt)

    def _refused(self, transfer: Transfer, attempt: Attempt) -> PlaceCheck:
        """Return what the arm cannot do of a transfer, from an attempt that failed."""
        obj, source, target, others = transfer
        model = self._scene.model
        if supports := self._attempts.unsteady(attempt):
            return PlaceCheck(obj, target, while_there(str(attempt.error), supports), put_unless=supports)
        crowding = self._attempts.crowding(obj, target) if attempt.done >= TAKEN else ()
        if crowded_by := tuple(one for one in crowding if one in others):
            return PlaceCheck(obj, target, crowded_by=crowded_by)
        unless = self._attempts.hindering(attempt)  # takes several rehearsals
        known = bool(attempt.for_good or unless)
        if attempt.done < TAKEN and (known or not target):
            reason = while_there(str(attempt.error), unless)
            return PlaceCheck(obj, source, reason, take=not attempt.for_good, take_unless=unless if known else others)
        reason = while_there(f"from {source}: {attempt.error}", unless)
        if not known or max(model.location(place).capacity for place in (source, target)) > 1:
            return PlaceCheck(obj, target, reason, put_unless=others, not_from=source)
        origins = self._attempts.beside(target, source)[:MORE_ORIGINS]
        anywhere = bool(unless) and not any(self._is_brought(transfer, origin) for origin in origins)
        return PlaceCheck(obj, target, reason, put_unless=unless, not_from="" if anywhere else source)

    def _is_brought(self, transfer: Transfer, origin: str) -> bool:
        """Return whether a transfer would succeed from another location, without what stands there."""
        with suppress(ModelError):
            places = vacated(self._scene.model, dict(transfer.others), origin)
            rehearsal = bringing(transfer.obj, origin, transfer.target, places).beginning(BROUGHT)
            return self._attempts.run(rehearsal)[1] is None
        return False

    def _carriers(self, transfer: Transfer) -> Neighbours:
        """Return what carries the object of a transfer, before and after it."""
        below = {place for end in (transfer.source, transfer.target) if end for place in under(self._scene.model, end)}
        return tuple(pair for pair in transfer.others if pair[1] in below)
