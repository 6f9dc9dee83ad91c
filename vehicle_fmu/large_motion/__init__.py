"""The touring motorcycle in large motion: tree of rigid bodies in space, tyres on a flat road, steady turning."""
