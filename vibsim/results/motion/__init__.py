"""What the columns of a run say of its parts: depths and rates, blows, distances, how often what happened."""
